#include "bake/rig/evaluate_parallel.h"

#include <algorithm>

namespace fb::bake {

void evaluate_parallel(Source& source, std::span<const float> controls, std::size_t count, std::span<float> points,
                       const Parallel& parallel) {
  // Few poses of a slow rig are spread too; blocks do not depend on the number of threads.
  const std::size_t block = std::clamp<std::size_t>(count / 8, 1, 32);
  const std::size_t width = source.schema().control_count(), size = source.rest().points.size();
  if (controls.size() != count * width || points.size() != count * size)
    fail(Status::invalid_argument, "%zu poses need %zu control values and %zu coordinates, not %zu and %zu", count,
         count * width, count * size, controls.size(), points.size());
  Parallel serial = parallel;
  serial.threads = 1;
  parallel_for(source.thread_safe() ? parallel : serial, (count + block - 1) / block,
               [&](std::size_t index, std::size_t) {
                 const std::size_t first = index * block, poses = std::min(block, count - first);
                 try {
                   source.evaluate(controls.subspan(first * width, poses * width), poses,
                                   points.subspan(first * size, poses * size));
                 } catch (const PoseError& error) {
                   throw PoseError(error.status(), first + error.pose(), error.reason());
                 }
               });
}

}  // namespace fb::bake
