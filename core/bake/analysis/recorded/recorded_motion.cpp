#include "bake/analysis/recorded/recorded_motion.h"

#include <algorithm>
#include <cmath>

#include "bake/analysis/activation_curve.h"

namespace fb::bake {

std::vector<float> motion_of(const RigSchema& schema, std::span<const SparseBlendshapes* const> parts,
                             std::size_t vertices, double diagonal, const Parallel& parallel) {
  const std::vector<float> rest = schema.rest_pose();
  std::vector<float> motion(rest.size() * vertices);
  parallel_for(parallel, rest.size(), [&](std::size_t c, std::size_t) {
    std::vector<float> moved(3 * vertices);
    for (const SparseBlendshapes* part : parts) {
      const auto has_control = [&](std::size_t control) {
        return std::any_of(part->features.begin(), part->features.end(),
                           [&](const Feature& f) { return !f.of_features() && f.control == control; });
      };
      if (!has_control(c)) continue;
      for (const double place : {-1.0, -0.5, 0.5, 1.0}) {
        if (!has_side(schema.controls[c], place > 0)) continue;
        std::vector<float> pose = rest;
        for (std::size_t other = 0; other < rest.size(); ++other)
          if (has_control(other))
            pose[other] = value_at(schema.controls[other], has_side(schema.controls[other], true) ? 1 : -1);
        pose[c] = value_at(schema.controls[c], place);
        std::fill(moved.begin(), moved.end(), 0.0f);
        part->add(pose, rest, 1, 1, moved);
        for (std::size_t v = 0; v < vertices; ++v)
          motion[c * vertices + v] =
              std::max(motion[c * vertices + v],
                       static_cast<float>(std::hypot(moved[3 * v], moved[3 * v + 1], moved[3 * v + 2]) / diagonal));
      }
    }
  });
  return motion;
}

std::vector<float> missed_with(const RecordedPoses& recorded, std::span<const float> motion, double diagonal,
                               const Parallel& parallel, Progress& progress) {
  const std::size_t width = recorded.rest.size(), vertices = motion.size() / width, size = 3 * vertices;
  const std::size_t count = recorded.picked.size();
  std::vector<float> missed(width * vertices);
  if (count == 0) return missed;
  constexpr std::size_t block = 64;
  std::vector<float> left, squares;
  std::vector<double> all(vertices), fourth(vertices);
  std::vector<float> on(width * vertices);
  std::vector<std::size_t> on_count(width);
  progress.begin("measuring what is left of recorded poses", count);
  for (std::size_t first = 0; first < count; first += block) {
    const std::size_t poses = std::min(block, count - first);
    left.resize(poses * size);
    squares.resize(poses * vertices);
    recorded.read(first, poses, left, parallel);
    parallel_for(parallel, poses, [&](std::size_t i, std::size_t) {
      for (std::size_t v = 0; v < vertices; ++v) {
        const float* d = left.data() + i * size + 3 * v;
        squares[i * vertices + v] = static_cast<float>(
            (double(d[0]) * d[0] + double(d[1]) * d[1] + double(d[2]) * d[2]) / (diagonal * diagonal));
      }
    });
    for (std::size_t i = 0; i < poses; ++i)
      for (std::size_t v = 0; v < vertices; ++v) {
        const double s = squares[i * vertices + v];
        all[v] += s;
        fourth[v] += s * s;
      }
    parallel_for(parallel, width, [&](std::size_t c, std::size_t) {
      for (std::size_t i = 0; i < poses; ++i) {
        if (recorded.pose(first + i)[c] == recorded.rest[c]) continue;
        ++on_count[c];
        for (std::size_t v = 0; v < vertices; ++v) on[c * vertices + v] += squares[i * vertices + v];
      }
    });
    progress.step(first + poses);
  }
  parallel_for(parallel, width, [&](std::size_t c, std::size_t) {
    const auto with = static_cast<double>(on_count[c]), without = static_cast<double>(count) - with;
    if (with == 0) return;
    for (std::size_t v = 0; v < vertices; ++v) {
      if (motion[c * vertices + v] <= 1e-5f) continue;
      const double mean_on = on[c * vertices + v] / with;
      const double mean_off = without > 0 ? std::max(0.0, all[v] - on[c * vertices + v]) / without : 0;
      const double mean = all[v] / double(count);
      const double variance = std::max(0.0, fourth[v] / double(count) - mean * mean);
      const double chance = without > 0 ? 2 * std::sqrt(variance * (1 / with + 1 / without)) : 0;
      if (mean_on - mean_off > chance) missed[c * vertices + v] = static_cast<float>(std::sqrt(mean_on - mean_off));
    }
  });
  return missed;
}

}  // namespace fb::bake
