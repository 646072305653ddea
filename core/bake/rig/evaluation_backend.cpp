#include "bake/rig/evaluation_backend.h"

#include <algorithm>

namespace fb::bake {

ThreadBackend::ThreadBackend(Source& source, const Parallel& parallel) : source_(source), parallel_(parallel) {
  if (!source.thread_safe()) parallel_.threads = 1;
}

void ThreadBackend::evaluate_block(std::span<const float> controls, std::size_t count, std::span<float> points) {
  // Few poses of a slow rig are spread too. Pieces do not depend on the number of threads.
  const std::size_t task_poses = std::clamp<std::size_t>(count / 8, 1, 32);
  const std::size_t width = source_.schema().control_count(), size = source_.rest().points.size();
  parallel_for(parallel_, (count + task_poses - 1) / task_poses, [&](std::size_t index, std::size_t) {
    const std::size_t first = index * task_poses, poses = std::min(task_poses, count - first);
    try {
      source_.evaluate(controls.subspan(first * width, poses * width), poses,
                       points.subspan(first * size, poses * size));
    } catch (const PoseError& error) {
      throw PoseError(error.status(), first + error.pose(), error.reason());
    }
  });
}

}  // namespace fb::bake
