#include "bake/rig/pose_rows.h"

#include <algorithm>
#include <vector>

namespace fb::bake {

void for_blocks(const PoseRows& poses, std::size_t block, const Parallel& parallel, Progress& progress,
                const std::function<void(std::size_t, std::size_t, const float*)>& visit) {
  std::vector<float> values(std::min(block, poses.size()) * poses.rows());
  for (std::size_t first = 0; first < poses.size(); first += block) {
    const std::size_t count = std::min(block, poses.size() - first);
    poses.read(first, count, std::span(values).first(count * poses.rows()), parallel);
    visit(first, count, values.data());
    progress.step(first + count);
  }
}

}  // namespace fb::bake
