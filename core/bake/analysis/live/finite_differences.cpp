#include "bake/analysis/live/finite_differences.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/analysis/blendshape_parts.h"
#include "bake/rig/random_pose.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Differences of each control. With 64, regions and inputs of the sample face came out worse: an mse of 2.4e-7 instead
// of 1.1e-7. add_missed_correctives looks for what so few do not show.
constexpr std::size_t most_probing_rounds = 16;
// Of displacements: those that parts of a base are judged by later, and those that are evaluated at once.
constexpr std::size_t kept_bytes = std::size_t{160} << 20, block_bytes = std::size_t{1} << 26;

// In every round, each control in random order, `per_pose` of them sharing a pose.
std::vector<FiniteDifference> plan_differences(const RigSchema& schema, std::uint64_t seed, std::size_t rounds,
                                               std::size_t per_pose) {
  const std::size_t width = schema.control_count(), poses = (width + per_pose - 1) / per_pose;
  std::vector<FiniteDifference> differences;
  for (std::size_t round = 0; round < rounds; ++round) {
    Random random = open_stream(seed, Stream::difference_order, round);
    std::vector<std::uint32_t> order(width);
    std::iota(order.begin(), order.end(), 0u);
    for (std::size_t i = width; i > 1; --i) std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
    for (std::size_t i = 0; i < width; ++i) {
      FiniteDifference& difference = differences.emplace_back();
      difference.pose = static_cast<std::uint32_t>(round * poses + i / per_pose);
      difference.control = order[i];
      Random value = open_stream(seed, Stream::difference_values, round * width + order[i]);
      difference.value = random_value(schema.controls[order[i]], value);
    }
  }
  return differences;
}

std::vector<float> draw_dense_poses(const RigSchema& schema, std::uint64_t seed, std::size_t poses) {
  std::vector<float> controls;
  for (std::size_t p = 0; p < poses; ++p) {
    Random random = open_stream(seed, Stream::difference_poses, p);
    const float density = random.uniform(0.1f, 0.5f);
    const std::vector<float> pose = random_pose(schema, density, random);
    controls.insert(controls.end(), pose.begin(), pose.end());
  }
  return controls;
}

// Evaluates so many of the dense poses: the displacements of some vertices, or of all.
void evaluate_poses(RigEvaluator& rig, const DenseDifferences& dense, std::size_t first, std::size_t count,
                    EvaluationStage& stage, std::span<const std::uint32_t> vertices, std::span<float> displacements) {
  const std::size_t width = rig.rest_pose().size();
  rig.evaluate_each(
      count, stage,
      [&](std::size_t i, std::span<float> pose) {
        std::copy_n(dense.controls.begin() + static_cast<std::ptrdiff_t>((first + i) * width), width, pose.begin());
      },
      [&](std::size_t i, std::span<const float>, std::span<float> displacement) {
        std::copy(displacement.begin(), displacement.end(),
                  displacements.begin() + static_cast<std::ptrdiff_t>(i * displacement.size()));
      },
      vertices);
}

// Evaluates the poses of some differences once more, with the control at rest where it is active, active where it is at
// rest. displacements: of the dense poses from `first` on.
void evaluate_changed_poses(RigEvaluator& rig, const DenseDifferences& dense, std::size_t first,
                            std::span<const float> displacements, std::span<FiniteDifference> differences,
                            EvaluationStage& stage) {
  const std::size_t width = rig.rest_pose().size(), size = rig.coordinate_count();
  const auto controls_of = [&](std::size_t p) { return std::span(dense.controls).subspan(p * width, width); };
  const double drop = 2e-6 * rig.diagonal();
  rig.evaluate_each(
      differences.size(), stage,
      [&](std::size_t i, std::span<float> pose) {
        const FiniteDifference& difference = differences[i];
        const std::span<const float> from = controls_of(difference.pose);
        std::copy(from.begin(), from.end(), pose.begin());
        const float rest = rig.rest_pose()[difference.control];
        pose[difference.control] = from[difference.control] != rest ? rest : difference.value;
      },
      [&](std::size_t i, std::span<const float> pose, std::span<float> displacement) {
        FiniteDifference& difference = differences[i];
        const float* base = displacements.data() + (difference.pose - first) * size;
        const bool was_active = pose[difference.control] == rig.rest_pose()[difference.control];
        const float sign = was_active ? -1.0f : 1.0f;
        for (std::size_t k = 0; k < size; ++k) displacement[k] = sign * (displacement[k] - base[k]);
        if (was_active) difference.value = controls_of(difference.pose)[difference.control];
        difference.moved = make_sparse(0, displacement, drop);
      });
}

// Evenly spaced vertices of the surface, and all that carry numbers, whose displacements in so many poses fit
// kept_bytes, about. Empty: all do.
std::vector<std::uint32_t> judged_vertices(const RigEvaluator& rig, std::size_t poses) {
  const std::size_t all = rig.coordinate_count() / 3, surface = rig.rest().surface_vertex_count();
  const std::size_t most = std::max<std::size_t>(1, kept_bytes / (3 * sizeof(float) * std::max<std::size_t>(poses, 1)));
  if (all <= most) return {};
  const std::size_t step = (surface + most - 1) / most;
  std::vector<std::uint32_t> judged;
  for (std::size_t v = 0; v < all; v += v < surface ? step : 1) judged.push_back(static_cast<std::uint32_t>(v));
  return judged;
}

}  // namespace

DenseDifferences evaluate_differences(RigEvaluator& rig, std::uint64_t seed, Progress& progress) {
  const RigSchema& schema = rig.schema();
  const std::size_t width = schema.control_count(), size = rig.coordinate_count();
  const std::size_t per_pose = std::clamp<std::size_t>(width / 16, 2, 16), poses = (width + per_pose - 1) / per_pose;
  // At most a quarter of the remaining budget: correctives need more.
  const std::size_t rounds = std::min<std::uint64_t>(most_probing_rounds, rig.remaining() / 4 / (width + poses));
  if (rounds < most_probing_rounds)
    progress.note(format("the budget of rig calls allows for %zu of %zu differences of each control in dense poses",
                         rounds, most_probing_rounds));
  DenseDifferences dense;
  dense.poses = rounds * poses;
  dense.differences = plan_differences(schema, seed, rounds, per_pose);
  dense.controls = draw_dense_poses(schema, seed, dense.poses);
  dense.judged = judged_vertices(rig, dense.poses);
  const std::size_t judged = dense.judged.empty() ? size : 3 * dense.judged.size();
  dense.displacements.resize(dense.poses * judged);
  EvaluationStage stage(progress, Phase::analysis, "evaluating dense poses", dense.poses + dense.differences.size());
  const std::size_t most = std::max<std::size_t>(1, block_bytes / (sizeof(float) * size));  // poses of a block
  std::vector<float> displacements;
  auto begin = dense.differences.begin();  // of a block: they are in the order of poses
  for (std::size_t first = 0; first < dense.poses; first += most) {
    const std::size_t count = std::min(most, dense.poses - first);
    displacements.resize(count * size);
    evaluate_poses(rig, dense, first, count, stage, {}, displacements);
    const auto end = std::find_if(begin, dense.differences.end(),
                                  [&](const FiniteDifference& difference) { return difference.pose >= first + count; });
    evaluate_changed_poses(rig, dense, first, displacements, {begin, end}, stage);
    begin = end;
    for (std::size_t i = 0; i < count; ++i) {
      const float* const from = displacements.data() + i * size;
      float* to = dense.displacements.data() + (first + i) * judged;
      if (dense.judged.empty()) std::copy_n(from, size, to);
      for (const std::uint32_t v : dense.judged) to = std::copy_n(from + 3 * std::size_t(v), 3, to);
    }
  }
  return dense;
}

void evaluate_displacements(RigEvaluator& rig, DenseDifferences& dense, Progress& progress) {
  EvaluationStage stage(progress, Phase::analysis, "evaluating dense poses", dense.poses);
  dense.displacements.resize(dense.poses * (dense.judged.empty() ? rig.coordinate_count() : 3 * dense.judged.size()));
  evaluate_poses(rig, dense, 0, dense.poses, stage, dense.judged, dense.displacements);
}

std::vector<float> difference_motion(const DenseDifferences& dense, const SparseBlendshapes& base, Statistic statistic,
                                     const RigEvaluator& rig) {
  const std::vector<float>& rest = rig.rest_pose();
  const std::size_t width = rest.size(), size = rig.coordinate_count(), vertices = size / 3;
  const bool largest = statistic == Statistic::largest;
  std::vector<std::vector<const FiniteDifference*>> of_control(width);
  for (const FiniteDifference& difference : dense.differences) of_control[difference.control].push_back(&difference);
  std::vector<float> motion(width * vertices);
  parallel_for(rig.parallel(), width, [&](std::size_t c, std::size_t) {
    std::vector<float> moved(size), pose(width), active(base.features.size()), inactive(base.features.size());
    std::vector<double> sums(vertices);
    for (const FiniteDifference* difference : of_control[c]) {
      std::fill(moved.begin(), moved.end(), 0.0f);
      for (std::size_t k = 0; k < difference->moved.vertices.size(); ++k)
        std::copy_n(difference->moved.offsets.data() + 3 * k, 3, moved.data() + 3 * difference->moved.vertices[k]);
      std::copy_n(dense.controls.data() + difference->pose * width, width, pose.data());
      pose[c] = difference->value;
      evaluate_features(base.features, pose, rest, active);
      pose[c] = rest[c];
      evaluate_features(base.features, pose, rest, inactive);
      for (const SparseShape& shape : base.shapes) {
        const float change = active[shape.feature] - inactive[shape.feature];
        if (change != 0) add_scaled(shape, -change, moved);
      }
      for (std::size_t v = 0; v < vertices; ++v) {
        const float* d = moved.data() + 3 * v;
        const double squares = double(d[0]) * d[0] + double(d[1]) * d[1] + double(d[2]) * d[2];
        sums[v] = largest ? std::max(sums[v], squares) : sums[v] + squares;
      }
    }
    const double share = largest || of_control[c].empty() ? 1 : double(of_control[c].size());
    for (std::size_t v = 0; v < vertices; ++v)
      motion[c * vertices + v] = static_cast<float>(std::sqrt(sums[v] / share) / rig.diagonal());
  });
  return motion;
}

}  // namespace fb::bake
