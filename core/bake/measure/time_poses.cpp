#include "bake/measure/time_poses.h"

#include <algorithm>
#include <numeric>

#include "base/thread_time.h"

namespace fb::bake {

std::vector<double> time_poses(const runtime::Evaluator& evaluator, std::span<const float> controls,
                               std::size_t rounds) {
  static const double overhead = clock_overhead(thread_time);
  const std::size_t width = evaluator.control_count(), poses = controls.size() / width;
  runtime::Workspace workspace(evaluator, 1);
  std::vector<float> positions(3 * evaluator.vertex_count());
  std::vector<double> least(poses, 1e30);
  for (std::size_t round = 0; round < rounds; ++round)
    for (std::size_t pose = 0; pose < poses; ++pose) {
      const double start = thread_time();
      evaluator.evaluate(controls.data() + pose * width, positions.data(), workspace);
      least[pose] = std::min(least[pose], std::max(0.0, thread_time() - start - overhead));
    }
  return least;
}

PoseTime pose_time(const PackedModel& model, const Clip& clip, const MachineClass& machine) {
  constexpr std::size_t rounds = 5;
  const runtime::Evaluator evaluator(model);
  const std::vector<double> times = time_poses(evaluator, clip.controls, rounds);
  return {.machine = machine,
          .predicted = mean_microseconds(model, clip, machine),
          .measured = std::accumulate(times.begin(), times.end(), 0.0) / double(times.size()),
          .measured_with = evaluator.kernels().name};
}

}  // namespace fb::bake
