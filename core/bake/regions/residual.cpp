#include "bake/regions/residual.h"

#include <algorithm>

#include "base/status.h"

namespace fb {

Residual::Residual(const PoseSet& poses, const CurveBase& base)
    : poses_(&poses), base_(&base), rest_(poses.source().schema().rest_pose()) {}

void Residual::read(std::size_t first, std::size_t count, std::span<float> values, const Parallel& parallel) const {
  if (first > size() || count > size() - first || values.size() != count * rows())
    fail(Status::invalid_argument, "poses %zu to %zu of %zu, %zu coordinates each, do not fit in %zu numbers", first,
         first + count, size(), rows(), values.size());
  constexpr std::size_t block = 16;
  const bool together = poses_->source().thread_safe();
  if (!together) poses_->read_displacements(first, count, values);
  parallel_for(parallel, (count + block - 1) / block, [&](std::size_t index, std::size_t) {
    const std::size_t begin = index * block, poses = std::min(block, count - begin);
    const std::span<float> part = values.subspan(begin * rows(), poses * rows());
    if (together) poses_->read_displacements(first + begin, poses, part);
    std::vector<float> controls(poses * rest_.size());
    poses_->read_controls(first + begin, poses, controls);
    base_->add(controls, rest_, poses, -1, part);
  });
}

}  // namespace fb
