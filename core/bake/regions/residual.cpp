#include "bake/regions/residual.h"

#include <algorithm>
#include <utility>

#include "base/status.h"

namespace fb::bake {

Residual::Residual(PoseSet poses, const SparseBlendshapes& base)
    : Residual(poses, std::make_shared<BlockedBlendshapes>(base, poses.source().rest().vertex_count())) {}

Residual::Residual(PoseSet poses, std::shared_ptr<const BlockedBlendshapes> base)
    : PoseRows(std::move(poses)), base_(std::move(base)), rest_(this->poses().source().schema().rest_pose()) {}

std::unique_ptr<PoseRows> Residual::subsampled(std::size_t count) const {
  return std::make_unique<Residual>(poses().subsampled(count), base_);
}

void Residual::read(std::size_t first, std::size_t count, std::span<float> values, const Parallel& parallel) const {
  if (first > size() || count > size() - first || values.size() != count * rows())
    fail(Status::invalid_argument, "poses %zu to %zu of %zu, %zu coordinates each, do not fit in %zu floats", first,
         first + count, size(), rows(), values.size());
  // Each task reads all blendshapes: as many poses as leave work for every thread.
  const std::size_t task_poses = std::clamp<std::size_t>(count / worker_count(parallel) / 16 * 16, 16, 64);
  const bool concurrent = poses().source().thread_safe();
  if (!concurrent) poses().read_displacements(first, count, values);
  parallel_for(parallel, (count + task_poses - 1) / task_poses, [&](std::size_t index, std::size_t) {
    const std::size_t begin = index * task_poses, some = std::min(task_poses, count - begin);
    const std::span<float> part = values.subspan(begin * rows(), some * rows());
    if (concurrent) poses().read_displacements(first + begin, some, part);
    std::vector<float> controls(some * rest_.size());
    poses().read_controls(first + begin, some, controls);
    base_->add(controls, rest_, some, -1, part);
  });
}

}  // namespace fb::bake
