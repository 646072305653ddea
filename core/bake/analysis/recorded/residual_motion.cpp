#include "bake/analysis/recorded/recorded_poses.h"

#include <algorithm>
#include <cmath>

#include "bake/analysis/activation_curve.h"

namespace fb::bake {

std::vector<float> part_motion(const RigSchema& schema, std::span<const SparseBlendshapes* const> parts,
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
      for (const double position : {-1.0, -0.5, 0.5, 1.0}) {
        if (!has_side(schema.controls[c], position > 0)) continue;
        std::vector<float> pose = rest;
        for (std::size_t other = 0; other < rest.size(); ++other)
          if (has_control(other))
            pose[other] = value_at(schema.controls[other], has_side(schema.controls[other], true) ? 1 : -1);
        pose[c] = value_at(schema.controls[c], position);
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

namespace {

constexpr std::size_t poses_a_block = 64;

// Sums over poses of squared residuals over D^2, of each vertex.
struct ResidualSums {
  std::vector<double> all, fourth;  // squares and their squares
  std::vector<float> active;        // controls x vertices: over poses in which the control is active
  std::vector<std::size_t> active_count;
};

ResidualSums sum_residuals(const RecordedPoses& recorded, std::size_t vertices, double diagonal,
                           const Parallel& parallel, Progress& progress) {
  const std::size_t width = recorded.rest.size(), size = 3 * vertices, count = recorded.picked.size();
  ResidualSums sums{std::vector<double>(vertices), std::vector<double>(vertices), std::vector<float>(width * vertices),
                    std::vector<std::size_t>(width)};
  std::vector<float> residuals, squares;
  progress.begin(Phase::analysis, "measuring residuals of recorded poses", count);
  for (std::size_t first = 0; first < count; first += poses_a_block) {
    const std::size_t poses = std::min(poses_a_block, count - first);
    residuals.resize(poses * size);
    squares.resize(poses * vertices);
    recorded.read(first, poses, residuals, parallel);
    parallel_for(parallel, poses, [&](std::size_t i, std::size_t) {
      for (std::size_t v = 0; v < vertices; ++v) {
        const float* d = residuals.data() + i * size + 3 * v;
        squares[i * vertices + v] = static_cast<float>(
            (double(d[0]) * d[0] + double(d[1]) * d[1] + double(d[2]) * d[2]) / (diagonal * diagonal));
      }
    });
    for (std::size_t i = 0; i < poses; ++i)
      for (std::size_t v = 0; v < vertices; ++v) {
        const double s = squares[i * vertices + v];
        sums.all[v] += s;
        sums.fourth[v] += s * s;
      }
    parallel_for(parallel, width, [&](std::size_t c, std::size_t) {
      for (std::size_t i = 0; i < poses; ++i) {
        if (recorded.pose(first + i)[c] == recorded.rest[c]) continue;
        ++sums.active_count[c];
        for (std::size_t v = 0; v < vertices; ++v) sums.active[c * vertices + v] += squares[i * vertices + v];
      }
    });
    progress.step(first + poses);
  }
  return sums;
}

}  // namespace

std::vector<float> residual_by_control(const RecordedPoses& recorded, std::span<const float> motion, double diagonal,
                                       const Parallel& parallel, Progress& progress) {
  const std::size_t width = recorded.rest.size(), vertices = motion.size() / width;
  const std::size_t count = recorded.picked.size();
  std::vector<float> larger(width * vertices);
  if (count == 0) return larger;
  const ResidualSums sums = sum_residuals(recorded, vertices, diagonal, parallel, progress);
  parallel_for(parallel, width, [&](std::size_t c, std::size_t) {
    const auto with = static_cast<double>(sums.active_count[c]), without = static_cast<double>(count) - with;
    if (with == 0) return;
    for (std::size_t v = 0; v < vertices; ++v) {
      if (motion[c * vertices + v] <= 1e-5f) continue;
      const double active = sums.active[c * vertices + v];
      const double mean_with = active / with;
      const double mean_without = without > 0 ? std::max(0.0, sums.all[v] - active) / without : 0;
      const double mean = sums.all[v] / double(count);
      const double variance = std::max(0.0, sums.fourth[v] / double(count) - mean * mean);
      const double chance = without > 0 ? 2 * std::sqrt(variance * (1 / with + 1 / without)) : 0;
      if (mean_with - mean_without > chance)
        larger[c * vertices + v] = static_cast<float>(std::sqrt(mean_with - mean_without));
    }
  });
  return larger;
}

}  // namespace fb::bake
