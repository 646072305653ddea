#include "bake/measure/locality.h"

#include <algorithm>
#include <cmath>
#include <list>

#include "archive/reader.h"
#include "bake/measure/evaluate.h"
#include "bake/measure/measured_face.h"
#include "bake/measure/vertex_distance.h"
#include "bake/rig/random_pose.h"
#include "bake/rig/scaled_source.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t moves_at_once = 64;  // controls moved in one call of the rig
constexpr std::size_t rest_poses = 2;      // poses in which controls are moved from rest; the others are random
constexpr std::size_t single_poses_a_control = 16;
constexpr double off_rest_least = 1e-6;  // of a control's reach: a recorded value no further from rest is at rest

// The pose from which controls are moved.
std::vector<float> pose_of(const RigSchema& schema, const LocalityOptions& options, std::size_t number) {
  if (number < rest_poses) return schema.rest_pose();
  Random random = open_stream(options.seed, Stream::locality_poses, number);
  return random_pose(schema, options.active, random);
}

float moved_value(const Control& control, float value, std::size_t number) {
  if (number < rest_poses) return number == 0 ? control.maximum : control.minimum;
  if (std::abs(value - control.rest) > 0.5f * control.reach()) return control.rest;
  return control.maximum - control.rest >= control.rest - control.minimum ? control.maximum : control.minimum;
}

// Largest displacement of each vertex by moving each control: controls x vertices, over D. Without the vertices that
// carry the numbers of joints, which come last in a pose.
using Motion = std::vector<float>;

struct Candidate {
  // `exponent`: of the archive's positions to the rig's, see scaled_source.h.
  Candidate(std::span<const std::byte> archive, int exponent, const Source& rig, const Parallel& parallel)
      : face(model_of(archive, exponent, rig), worker_count(parallel)),
        motion(rig.schema().control_count() * rig.rest().first_joint_coordinate() / 3) {
    for (const Control& control : rig.schema().controls) alone.push_back({control.name});
  }
  static PackedModel model_of(std::span<const std::byte> archive, int exponent, const Source& rig) {
    PackedModel model = scaled(archive::read_archive(archive).model, exponent);
    check_same_face(model, rig);
    return model;
  }
  // Counts a pose of one control alone.
  void add_alone(std::size_t control, std::span<const float> truth, std::span<const float> posed, const Mesh& rest,
                 bool unseen) {
    ControlLeak& mine = alone[control];
    const double diagonal = rest.diagonal();
    ++mine.alone_poses;
    mine.unseen_poses += unseen;
    mine.alone_error = std::max(mine.alone_error, furthest_vertex(truth, posed).distance / diagonal);
    mine.alone_motion = std::max(mine.alone_motion, furthest_vertex(truth, rest.points).distance / diagonal);
  }

  MeasuredFace face;
  Motion motion;
  std::vector<ControlLeak> alone;  // one a control
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
    raise_to_distances(std::span(motion).subspan((moves.first + i) * vertices, vertices),
                       std::span(points).subspan((i + 1) * width, width), std::span(points).first(width), diagonal);
  });
}

// `alone`: one a control, with what was measured of it alone; controls without poses are left out.
Locality locality_of(const Motion& rig, const Motion& archive, const std::vector<ControlLeak>& alone,
                     const LocalityOptions& options) {
  Locality locality;
  locality.options = options;
  const std::size_t controls = alone.size(), vertices = rig.size() / controls;
  std::size_t above = 0;
  for (std::size_t c = 0; c < controls; ++c) {
    if (alone[c].alone_poses == 0) continue;
    ControlLeak leak = alone[c];
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
  locality.above = static_cast<double>(above) / static_cast<double>(locality.leaks.size());
  return locality;
}

// See measure_locality; `exponent`: of the archives' positions to the rig's.
std::vector<Locality> measure_scaled(std::span<const std::span<const std::byte>> archives, int exponent,
                                     RigEvaluator& rig, const LocalityOptions& options, Progress& progress) {
  const Parallel& parallel = rig.parallel();
  std::list<Candidate> candidates;
  for (const auto& archive : archives) candidates.emplace_back(archive, exponent, rig, parallel);
  const std::size_t controls = rig.schema().control_count(), width = rig.rest().first_joint_coordinate();
  const std::size_t all = rig.rest().points.size();
  const double diagonal = rig.rest().diagonal();
  Motion truth(controls * width / 3);
  progress.begin(Phase::measuring, "measuring locality", options.poses * controls);
  for (std::size_t p = 0; p < options.poses; ++p) {
    const std::vector<float> pose = pose_of(rig.schema(), options, p);
    for (std::size_t first = 0; first < controls; first += moves_at_once) {
      const Moves moves = moves_from(rig.schema(), pose, p, first, std::min(moves_at_once, controls - first));
      std::vector<float> evaluated((moves.count + 1) * all), expected((moves.count + 1) * width),
          points(expected.size());
      rig.evaluate_cached(moves.poses, moves.count + 1, evaluated);
      for (std::size_t i = 0; i <= moves.count; ++i) std::copy_n(&evaluated[i * all], width, &expected[i * width]);
      raise_by(truth, moves, expected, diagonal, parallel);
      for (Candidate& candidate : candidates) {
        parallel_for(parallel, moves.count + 1, [&](std::size_t i, std::size_t worker) {
          const auto posed = candidate.face.points(&moves.poses[i * controls], worker).first(width);
          std::ranges::copy(posed, &points[i * width]);
          if (p < rest_poses && i > 0 && moves.poses[i * controls + first + i - 1] != pose[first + i - 1])
            candidate.add_alone(first + i - 1, std::span(expected).subspan(i * width, width), posed, rig.rest(), true);
        });
        raise_by(candidate.motion, moves, points, diagonal, parallel);
      }
      progress.step(p * controls + first + moves.count);
    }
  }
  std::vector<Locality> localities;
  for (const Candidate& candidate : candidates)
    localities.push_back(locality_of(truth, candidate.motion, candidate.alone, options));
  return localities;
}

// A recorded pose in which one control is off rest.
struct SinglePose {
  std::size_t control = 0, clip = 0, frame = 0;
  double distance = 0;  // from rest, in units of the control's reach
};

std::vector<SinglePose> single_poses(const Source& recording) {
  const RigSchema& schema = recording.schema();
  std::vector<std::vector<SinglePose>> of_control(schema.control_count());
  for (std::size_t k = 0; k < recording.clips().size(); ++k) {
    const Clip& clip = recording.clips()[k];
    for (std::size_t f = 0; recording.readable(k) && f < clip.frames; ++f) {
      SinglePose single{0, k, f};
      std::size_t off_rest = 0;
      for (std::size_t c = 0; c < schema.control_count() && off_rest < 2; ++c) {
        const Control& control = schema.controls[c];
        const double distance =
            std::abs(double(clip.controls[f * schema.control_count() + c]) - control.rest) / control.reach();
        if (distance <= off_rest_least) continue;
        ++off_rest;
        single.control = c;
        single.distance = distance;
      }
      if (off_rest == 1) of_control[single.control].push_back(single);
    }
  }
  std::vector<SinglePose> singles;
  for (std::vector<SinglePose>& mine : of_control) {
    std::stable_sort(mine.begin(), mine.end(),
                     [](const SinglePose& a, const SinglePose& b) { return a.distance > b.distance; });
    mine.resize(std::min(mine.size(), single_poses_a_control));
    singles.insert(singles.end(), mine.begin(), mine.end());
  }
  return singles;
}

std::vector<Locality> measure_recorded(std::span<const std::span<const std::byte>> archives, int exponent,
                                       Source& recording, const Parallel& parallel, Progress& progress) {
  const std::vector<SinglePose> singles = single_poses(recording);
  if (singles.empty()) return {};
  std::list<Candidate> candidates;
  for (const auto& archive : archives) candidates.emplace_back(archive, exponent, recording, parallel);
  const Mesh& rest = recording.rest();
  const std::size_t controls = recording.schema().control_count(), kept = rest.first_joint_coordinate();
  const std::size_t vertices = kept / 3;
  const double diagonal = rest.diagonal();
  Motion truth(controls * vertices);
  std::vector<float> expected(rest.points.size());
  progress.begin(Phase::measuring, "measuring locality", singles.size());
  for (std::size_t i = 0; i < singles.size(); ++i) {
    const SinglePose& single = singles[i];
    const Clip& clip = recording.clips()[single.clip];
    recording.read(single.clip, single.frame, 1, expected);
    raise_to_distances(std::span(truth).subspan(single.control * vertices, vertices), expected, rest.points, diagonal);
    for (Candidate& candidate : candidates) {
      const auto posed = candidate.face.points(&clip.controls[single.frame * controls]).first(kept);
      raise_to_distances(std::span(candidate.motion).subspan(single.control * vertices, vertices), posed, rest.points,
                         diagonal);
      candidate.add_alone(single.control, std::span(expected).first(kept), posed, rest, clip.split != Split::train);
    }
    progress.step(i + 1);
  }
  std::vector<Locality> localities;
  for (const Candidate& candidate : candidates) {
    localities.push_back(locality_of(truth, candidate.motion, candidate.alone, {}));
    localities.back().recorded_poses = singles.size();
  }
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

std::vector<Locality> recorded_locality(std::span<const std::span<const std::byte>> archives, Source& recording,
                                        const Parallel& parallel, Progress& progress) {
  const int exponent = scale_exponent(recording.rest());
  if (exponent == 0) return measure_recorded(archives, 0, recording, parallel, progress);
  ScaledSource ordinary(recording, exponent);
  return measure_recorded(archives, exponent, ordinary, parallel, progress);
}

}  // namespace fb::bake
