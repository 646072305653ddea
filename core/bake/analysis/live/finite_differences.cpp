#include "bake/analysis/live/finite_differences.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/analysis/blendshape_parts.h"
#include "base/random.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t most_rounds = 16;  // toggles of each control

// Streams of the random numbers drawn here.
enum class Draw : std::uint64_t { order = 1, pose = 2, toggle = 3 };

Random open_stream(std::uint64_t seed, Draw use, std::uint64_t item) {
  return Random(seed, static_cast<std::uint64_t>(use) << 48 | item);
}

float draw_value(const Control& control, Random& random) {
  return std::clamp(random.uniform(control.minimum, control.maximum), control.minimum, control.maximum);
}

// For every control in every round the number of its pose: controls in random order, a few to a pose.
std::vector<FiniteDifference> plan_differences(const RigSchema& schema, std::uint64_t seed, std::size_t rounds,
                                               std::size_t together) {
  const std::size_t width = schema.control_count(), poses = (width + together - 1) / together;
  std::vector<FiniteDifference> differences;
  for (std::size_t round = 0; round < rounds; ++round) {
    Random random = open_stream(seed, Draw::order, round);
    std::vector<std::uint32_t> order(width);
    std::iota(order.begin(), order.end(), 0u);
    for (std::size_t i = width; i > 1; --i) std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
    for (std::size_t i = 0; i < width; ++i) {
      FiniteDifference& toggle = differences.emplace_back();
      toggle.pose = static_cast<std::uint32_t>(round * poses + i / together);
      toggle.control = order[i];
      Random value = open_stream(seed, Draw::toggle, round * width + order[i]);
      toggle.value = draw_value(schema.controls[order[i]], value);
    }
  }
  return differences;
}

}  // namespace

DenseDifferences evaluate_differences(RigEvaluator& rig, std::uint64_t seed, Progress& progress) {
  const RigSchema& schema = rig.schema();
  const std::size_t width = schema.control_count(), size = rig.coordinate_count();
  const std::size_t together = std::clamp<std::size_t>(width / 16, 2, 16), poses = (width + together - 1) / together;
  // A quarter of what is left at most: correctives cost more.
  const std::size_t rounds = std::min<std::uint64_t>(most_rounds, rig.remaining() / 4 / (width + poses));
  if (rounds < most_rounds)
    progress.note(
        format("the budget of rig calls allows %zu of %zu tries of each control among many", rounds, most_rounds));
  DenseDifferences dense;
  dense.poses = rounds * poses;
  dense.differences = plan_differences(schema, seed, rounds, together);
  for (std::size_t p = 0; p < dense.poses; ++p) {
    Random random = open_stream(seed, Draw::pose, p);
    const float density = random.uniform(0.1f, 0.5f);
    for (const Control& control : schema.controls) {
      const bool on = random.uniform() < density;
      const float value = draw_value(control, random);
      dense.controls.push_back(on ? value : control.rest);
    }
  }
  const auto controls_of = [&](std::size_t p) { return std::span(dense.controls).subspan(p * width, width); };
  dense.displacements.resize(dense.poses * size);
  EvaluationStage stage(progress, "evaluating many controls", dense.poses + dense.differences.size());
  rig.evaluate_each(
      dense.poses, stage,
      [&](std::size_t p, std::span<float> pose) {
        std::copy(controls_of(p).begin(), controls_of(p).end(), pose.begin());
      },
      [&](std::size_t p, std::span<const float>, std::span<float> displacement) {
        std::copy(displacement.begin(), displacement.end(), dense.displacements.begin() + p * size);
      });
  const double drop = 2e-6 * rig.diagonal();
  rig.evaluate_each(
      dense.differences.size(), stage,
      [&](std::size_t i, std::span<float> pose) {
        FiniteDifference& toggle = dense.differences[i];
        const std::span<const float> from = controls_of(toggle.pose);
        std::copy(from.begin(), from.end(), pose.begin());
        if (from[toggle.control] != rig.rest_pose()[toggle.control])
          pose[toggle.control] = rig.rest_pose()[toggle.control];
        else
          pose[toggle.control] = toggle.value;
      },
      [&](std::size_t i, std::span<const float> pose, std::span<float> displacement) {
        FiniteDifference& toggle = dense.differences[i];
        const float* base = dense.displacements.data() + toggle.pose * size;
        const bool was_on = pose[toggle.control] == rig.rest_pose()[toggle.control];
        const float sign = was_on ? -1.0f : 1.0f;
        for (std::size_t k = 0; k < size; ++k) displacement[k] = sign * (displacement[k] - base[k]);
        if (was_on) toggle.value = controls_of(toggle.pose)[toggle.control];
        toggle.moved = make_sparse(0, displacement, drop);
      });
  return dense;
}

std::vector<float> difference_motion(const DenseDifferences& dense, const SparseBlendshapes& base, Over over,
                                     const RigEvaluator& rig) {
  const std::size_t width = rig.rest_pose().size(), size = rig.coordinate_count(), vertices = size / 3;
  std::vector<std::vector<const FiniteDifference*>> of_control(width);
  for (const FiniteDifference& toggle : dense.differences) of_control[toggle.control].push_back(&toggle);
  std::vector<float> motion(width * vertices);
  parallel_for(rig.parallel(), width, [&](std::size_t c, std::size_t) {
    std::vector<float> moved(size), pose(width), on(base.features.size()), off(base.features.size());
    std::vector<double> sums(vertices);
    for (const FiniteDifference* toggle : of_control[c]) {
      std::fill(moved.begin(), moved.end(), 0.0f);
      for (std::size_t k = 0; k < toggle->moved.vertices.size(); ++k)
        std::copy_n(toggle->moved.offsets.data() + 3 * k, 3, moved.data() + 3 * toggle->moved.vertices[k]);
      std::copy_n(dense.controls.data() + toggle->pose * width, width, pose.data());
      pose[c] = toggle->value;
      evaluate_features(base.features, pose, rig.rest_pose(), on);
      pose[c] = rig.rest_pose()[c];
      evaluate_features(base.features, pose, rig.rest_pose(), off);
      for (const SparseShape& shape : base.shapes) {
        const float change = on[shape.feature] - off[shape.feature];
        if (change != 0) add_scaled(shape, -change, moved);
      }
      for (std::size_t v = 0; v < vertices; ++v) {
        const float* d = moved.data() + 3 * v;
        const double squares = double(d[0]) * d[0] + double(d[1]) * d[1] + double(d[2]) * d[2];
        sums[v] = over == Over::largest ? std::max(sums[v], squares) : sums[v] + squares;
      }
    }
    const double share = over == Over::largest || of_control[c].empty() ? 1 : double(of_control[c].size());
    for (std::size_t v = 0; v < vertices; ++v)
      motion[c * vertices + v] = static_cast<float>(std::sqrt(sums[v] / share) / rig.diagonal());
  });
  return motion;
}

}  // namespace fb::bake
