#include "bake/sampling/linear_rig.h"

#include <cmath>
#include <vector>

#include "bake/sampling/pose_generators.h"
#include "base/random_streams.h"

namespace fb::bake {
namespace {

constexpr std::size_t linear_probes = 64;
constexpr double linear_tolerance = 1e-5;  // over D

// The poses of a probe, one behind the other.
enum ProbePose { whole, one_part, other_part, halfway, probe_poses };

std::vector<float> draw_probe(const RigSchema& schema, const std::vector<float>& rest, Random& random) {
  const std::size_t width = rest.size();
  std::vector<float> poses;
  for (int p = 0; p < probe_poses; ++p) poses.insert(poses.end(), rest.begin(), rest.end());
  const auto set = [&](ProbePose pose, std::size_t control, float value) { poses[pose * width + control] = value; };
  for (std::size_t c = 0; c < width; ++c) {
    const Control& control = schema.controls[c];
    const bool up = draw_end(control, random);
    const float fraction = random.uniform(0.2f, 1.0f);
    const bool one = random.uniform() < 0.5f;
    if (random.uniform() < 0.5f) continue;
    const float value = value_toward(control, up, fraction);
    set(whole, c, value);
    set(one ? one_part : other_part, c, value);
    set(halfway, c, control.rest + (value - control.rest) / 2);
  }
  return poses;
}

bool adds_up(std::span<const float> points, std::span<const float> rest, double tolerance) {
  const std::size_t size = rest.size();
  for (std::size_t i = 0; i < size; ++i) {
    const auto moved = [&](ProbePose pose) { return double(points[pose * size + i]) - rest[i]; };
    if (!(std::abs(moved(whole) - moved(one_part) - moved(other_part)) <= tolerance)) return false;
    if (!(std::abs(moved(whole) / 2 - moved(halfway)) <= tolerance)) return false;
  }
  return true;
}

}  // namespace

bool is_linear(RigEvaluator& rig, std::uint64_t seed, Progress& progress) {
  const PurposeScope purpose(rig, EvaluationPurpose::analysis);
  const std::span<const float> rest = rig.rest().points;
  const double tolerance = linear_tolerance * rig.diagonal();
  std::vector<float> points(probe_poses * rest.size());
  progress.begin(Phase::sampling, "looking whether controls add up", linear_probes);
  try {
    for (std::size_t probe = 0; probe < linear_probes; ++probe) {
      Random random = open_stream(seed, Stream::linear_probes, probe);
      rig.evaluate_cached(draw_probe(rig.schema(), rig.rest_pose(), random), probe_poses, points);
      if (!adds_up(points, rest, tolerance)) return false;
      progress.step(probe + 1);
    }
  } catch (const PoseError&) {
    return false;
  }
  return true;
}

}  // namespace fb::bake
