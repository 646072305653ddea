#include "bake/face/region_poses.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/sampling/pose_generators.h"
#include "base/random_streams.h"

namespace fb::bake {
namespace {

constexpr std::size_t most_poses = 150'000, most_times = 16;

std::vector<float> draw_region_pose(const RigSchema& schema, const FaceRegion& region, Random random) {
  constexpr float powers[] = {0.5f, 1.0f, 2.0f};  // of uniform numbers: mostly far from rest, evenly, mostly near it
  constexpr float full = 0.15f;
  std::vector<float> pose = schema.rest_pose();
  const float most = *std::ranges::max_element(region.motion), density = random.uniform(0.1f, 1.0f);
  const float power = powers[random.below(3)];
  for (std::size_t k = 0; k < region.controls.size(); ++k) {
    if (random.uniform() >= density * std::sqrt(region.motion[k] / most)) continue;
    const Control& control = schema.controls[region.controls[k]];
    const bool up = draw_end(control, random);
    const float fraction = random.uniform() < full ? 1 : std::pow(random.uniform(), power);
    pose[region.controls[k]] = value_toward(control, up, fraction);
  }
  return pose;
}

}  // namespace

std::size_t region_pose_count(std::size_t poses) {
  return std::min(most_times * poses, most_poses - std::min(poses, most_poses));
}

std::vector<std::size_t> region_pose_counts(std::size_t poses, std::span<const double> errors) {
  double sum = 0;
  for (const double error : errors) sum += std::sqrt(error);
  std::vector<std::size_t> counts;
  for (const double error : errors)
    counts.push_back(sum > 0 ? static_cast<std::size_t>(double(poses) * std::sqrt(error) / sum) : 0);
  return counts;
}

RegionPoses region_poses(RigEvaluator& rig, const SparseBlendshapes& base, const FaceRegion& region,
                         const LocalBasis& basis, std::size_t number, std::size_t count, std::uint64_t seed,
                         EvaluationStage& stage) {
  const std::size_t width = rig.rest_pose().size();
  RegionPoses poses;
  for (std::uint64_t p = 0; p < count; ++p) {
    const std::vector<float> pose = draw_region_pose(
        rig.schema(), region, open_stream(seed, Stream::region_poses, std::uint64_t(number) << 32 | p));
    poses.controls.insert(poses.controls.end(), pose.begin(), pose.end());
  }
  poses.coefficients.resize(count * basis.count);
  const SparseBlendshapes part = part_of(base, region.vertices);
  FaceRegion alone = region;  // on a mesh of its vertices
  std::iota(alone.vertices.begin(), alone.vertices.end(), 0u);
  rig.evaluate_each(
      count, stage,
      [&](std::size_t p, std::span<float> controls) {
        std::copy_n(poses.controls.begin() + std::ptrdiff_t(p * width), width, controls.begin());
      },
      [&](std::size_t p, std::span<const float> controls, std::span<float> displacement) {
        part.add(controls, rig.rest_pose(), 1, -1, displacement);
        project_poses(alone, basis, displacement, 1, &poses.coefficients[p * basis.count]);
      },
      region.vertices);
  return poses;
}

}  // namespace fb::bake
