#include "bake/measure/locality.h"

#include <algorithm>
#include <cmath>
#include <list>

#include "archive/reader.h"
#include "bake/measure/evaluate.h"
#include "bake/rig/scaled_source.h"
#include "base/random.h"
#include "base/status.h"
#include "base/vector3.h"
#include "runtime/evaluator.h"

namespace fb::bake {
namespace {

constexpr std::size_t moves_at_once = 64;  // controls moved in one call of the rig
constexpr std::size_t rest_poses = 2;      // poses in which controls are moved from rest; the others are random

// The pose from which controls are moved.
std::vector<float> pose_of(const RigSchema& schema, const LocalityOptions& options, std::size_t number) {
  if (number < rest_poses) return schema.rest_pose();
  Random random(options.seed, number);
  std::vector<float> pose;
  for (const Control& control : schema.controls) {
    const bool on = random.uniform() < options.active;
    const float value = random.uniform(control.minimum, control.maximum);
    pose.push_back(on ? value : control.rest);
  }
  return pose;
}

float moved_value(const Control& control, float value, std::size_t number) {
  if (number < rest_poses) return number == 0 ? control.maximum : control.minimum;
  if (std::abs(value - control.rest) > 0.5f * control.reach()) return control.rest;
  return control.maximum - control.rest >= control.rest - control.minimum ? control.maximum : control.minimum;
}

// most[v] = max(most[v], distance of vertex v between two poses / D).
void raise(std::span<float> most, std::span<const float> from, std::span<const float> to, double diagonal) {
  for (std::size_t v = 0; v < most.size(); ++v) {
    const float distance = length(vector_at(to.data(), v) - vector_at(from.data(), v));
    most[v] = std::max(most[v], static_cast<float>(distance / diagonal));
  }
}

// Largest displacement of each vertex by moving each control: controls x vertices, over D.
using Motion = std::vector<float>;

struct Candidate {
  // `exponent`: of the archive's positions to the rig's, see scaled_source.h.
  Candidate(std::span<const std::byte> archive, int exponent, const Source& rig, const Parallel& parallel)
      : face(model_of(archive, exponent, rig)), motion(rig.schema().control_count() * rig.rest().vertex_count()) {
    for (std::size_t w = 0; w < worker_count(parallel); ++w) work.emplace_back(face);
  }
  static PackedModel model_of(std::span<const std::byte> archive, int exponent, const Source& rig) {
    PackedModel model = scaled(archive::read_archive(archive).model, exponent);
    check_same_face(model, rig);
    return model;
  }
  runtime::Evaluator face;
  std::vector<runtime::Workspace> work;  // one a worker
  Motion motion;
};

// Poses that differ from one pose in one control each.
struct Moves {
  std::vector<float> poses;  // that pose, then one with each of the controls from `first` on moved
  std::size_t first = 0, count = 0;
};

Moves moves_from(const RigSchema& schema, const std::vector<float>& pose, std::size_t number, std::size_t first,
                 std::size_t count) {
  Moves moves{pose, first, count};
  for (std::size_t c = first; c < first + count; ++c) {
    moves.poses.insert(moves.poses.end(), pose.begin(), pose.end());
    moves.poses[moves.poses.size() - pose.size() + c] = moved_value(schema.controls[c], pose[c], number);
  }
  return moves;
}

// `points`: positions of all poses of the moves.
void raise_by(Motion& motion, const Moves& moves, const std::vector<float>& points, double diagonal,
              const Parallel& parallel) {
  const std::size_t width = points.size() / (moves.count + 1), vertices = width / 3;
  parallel_for(parallel, moves.count, [&](std::size_t i, std::size_t) {
    raise(std::span(motion).subspan((moves.first + i) * vertices, vertices), std::span(points).first(width),
          std::span(points).subspan((i + 1) * width, width), diagonal);
  });
}

Locality locality_of(const Motion& rig, const Motion& archive, const RigSchema& schema,
                     const LocalityOptions& options) {
  Locality locality;
  locality.options = options;
  const std::size_t controls = schema.control_count(), vertices = rig.size() / controls;
  std::size_t above = 0;
  for (std::size_t c = 0; c < controls; ++c) {
    ControlLeak leak{schema.controls[c].name};
    for (std::uint32_t v = 0; v < vertices; ++v)
      if (rig[c * vertices + v] <= options.still && archive[c * vertices + v] > leak.leak) {
        leak.leak = archive[c * vertices + v];
        leak.vertex = v;
      }
    above += leak.leak > options.tolerance;
    locality.leaks.push_back(std::move(leak));
  }
  std::stable_sort(locality.leaks.begin(), locality.leaks.end(),
                   [](const ControlLeak& a, const ControlLeak& b) { return a.leak > b.leak; });
  locality.largest = locality.leaks.at(0).leak;
  locality.above = static_cast<double>(above) / static_cast<double>(controls);
  return locality;
}

// See measure_locality; `exponent`: of the archives' positions to the rig's.
std::vector<Locality> measure_scaled(std::span<const std::span<const std::byte>> archives, int exponent,
                                     RigEvaluator& rig, const LocalityOptions& options, Progress& progress) {
  const Parallel& parallel = rig.parallel();
  std::list<Candidate> candidates;
  for (const auto& archive : archives) candidates.emplace_back(archive, exponent, rig, parallel);
  const std::size_t controls = rig.schema().control_count(), width = rig.rest().points.size();
  const double diagonal = rig.rest().diagonal();
  Motion truth(controls * width / 3);
  progress.begin("measuring locality", options.poses * controls);
  for (std::size_t p = 0; p < options.poses; ++p) {
    const std::vector<float> pose = pose_of(rig.schema(), options, p);
    for (std::size_t first = 0; first < controls; first += moves_at_once) {
      const Moves moves = moves_from(rig.schema(), pose, p, first, std::min(moves_at_once, controls - first));
      std::vector<float> points((moves.count + 1) * width);
      rig.evaluate_cached(moves.poses, moves.count + 1, points);
      raise_by(truth, moves, points, diagonal, parallel);
      for (Candidate& candidate : candidates) {
        parallel_for(parallel, moves.count + 1, [&](std::size_t i, std::size_t worker) {
          candidate.face.evaluate(&moves.poses[i * controls], &points[i * width], candidate.work[worker]);
        });
        raise_by(candidate.motion, moves, points, diagonal, parallel);
      }
      progress.step(p * controls + first + moves.count);
    }
  }
  std::vector<Locality> localities;
  for (const Candidate& candidate : candidates)
    localities.push_back(locality_of(truth, candidate.motion, rig.schema(), options));
  return localities;
}

}  // namespace

std::uint64_t locality_calls(const LocalityOptions& options, std::size_t controls) {
  return options.poses * (controls + (controls + moves_at_once - 1) / moves_at_once);
}

std::optional<LocalityOptions> locality_within(std::uint64_t calls, std::size_t controls) {
  LocalityOptions options;
  while (options.poses > 0 && locality_calls(options, controls) > calls) --options.poses;
  return options.poses > 0 ? std::optional(options) : std::nullopt;
}

std::vector<Locality> measure_locality(std::span<const std::span<const std::byte>> archives, RigEvaluator& rig,
                                       const LocalityOptions& options, Progress& progress) {
  if (!rig.live()) fail(Status::invalid_argument, "\"%s\" is no live rig", rig.schema().name.c_str());
  const int exponent = scale_exponent(rig.rest());
  if (exponent == 0) return measure_scaled(archives, 0, rig, options, progress);
  ScaledSource ordinary(rig, exponent);
  RigEvaluator evaluator(ordinary, rig.parallel());
  return measure_scaled(archives, exponent, evaluator, options, progress);
}

}  // namespace fb::bake
