#include "solve/mesh_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "base/status.h"
#include "solve/closest_pairs.h"
#include "solve/first_guesses.h"

namespace fb::tool {
namespace {

constexpr std::size_t coarse_samples = 160;  // of each side, while there are many guesses
// How many guesses take the first steps, are followed from there, and are refined.
constexpr std::size_t most_first = 150, most_followed = 10, most_refined = 4;

// How the closest pairs of a placement are found, of few points or of all.
using Directions = std::vector<std::vector<ClosestPair>>;
using FindPairs = std::function<Directions(const Similarity&, bool all)>;

// What is aligned.
struct Task {
  FindPairs find;
  double least_kept = 0;       // share of the pairs
  double least = 0, most = 0;  // bounds of the scale
  bool first_free = false;     // whether the scale is free from the first steps on
  double size = 0;             // of the face
};

struct Placement {
  Similarity to_face;
  double score = INFINITY, rms = 0, kept = 0;
  std::array<double, 3> middle{};  // of the kept pairs, on the face
};

// The placement's score, and its kept pairs.
std::vector<ClosestPair> measure(Placement& placement, const Task& task, bool all) {
  std::vector<ClosestPair> kept;
  double scores = 0, squares = 0, share = 0;
  const auto directions = task.find(placement.to_face, all);
  for (std::vector<ClosestPair> pairs : directions) {
    const PairStatistics found = keep_closest(pairs, task.least_kept);
    scores += found.score * found.score;
    squares += found.rms * found.rms;
    share = std::max(share, found.kept);
    kept.insert(kept.end(), pairs.begin(), pairs.end());
  }
  placement.middle = {};
  for (const ClosestPair& pair : kept) {
    placement.middle[0] += double(pair.to.x) / static_cast<double>(kept.size());
    placement.middle[1] += double(pair.to.y) / static_cast<double>(kept.size());
    placement.middle[2] += double(pair.to.z) / static_cast<double>(kept.size());
  }
  const auto count = static_cast<double>(directions.size());
  placement.score = std::sqrt(scores / count);
  placement.rms = std::sqrt(squares / count);
  placement.kept = share;
  return kept;
}

class Aligner {
 public:
  explicit Aligner(Task task) : task_(std::move(task)) {}

  double size() const { return task_.size; }
  bool fixed_scale() const { return !(task_.least < task_.most); }

  // Steps from point to point: they go far.
  void approach(Placement& placement, int steps) const {
    Placement best = placement;
    for (int i = 0; i < steps; ++i) {
      const std::vector<ClosestPair> pairs = measure(placement, task_, false);
      if (placement.score < best.score) best = placement;
      std::vector<PointPair> points;
      for (const ClosestPair& pair : pairs) points.push_back({pair.from, pair.to});
      const auto step = align_pairs(points, task_.first_free ? std::nullopt : std::optional(1.0));
      if (!step) break;
      placement.to_face = bounded(*step, placement);
    }
    measure(placement, task_, false);
    if (!(placement.score < best.score)) placement = best;
  }

  // Steps along planes: they end exactly. Gives the best placement met.
  Placement refine(Placement placement, int most_steps) const {
    constexpr int patience = 6;
    constexpr double settled = 1e-6;  // movement of a step, as a share of the face's size
    Placement best = placement;
    best.score = INFINITY;
    for (int i = 0, worse = 0; i < most_steps && worse < patience; ++i) {
      const std::vector<ClosestPair> pairs = measure(placement, task_, true);
      if (placement.score < best.score) {
        best = placement;
        worse = 0;
      } else {
        ++worse;
      }
      std::vector<PlanePair> planes;
      for (const ClosestPair& pair : pairs) planes.push_back({pair.from, pair.to, pair.normal});
      if (planes.size() < 7) break;
      const Similarity step = plane_step(planes, fixed_scale());
      placement.to_face = bounded(step, placement);
      double moved = 0;
      for (const PlanePair& pair : planes) moved = std::max(moved, double(length(step(pair.from) - pair.from)));
      if (moved < settled * task_.size) break;
    }
    return best;
  }

 private:
  // A placement after a step, with the scale within its bounds, about the middle of the pairs.
  Similarity bounded(const Similarity& step, const Placement& placement) const {
    Similarity s = after(step, placement.to_face);
    const double scale = std::clamp(s.scale, task_.least, task_.most), ratio = scale / s.scale;
    if (ratio == 1) return s;
    for (std::size_t k = 0; k < 3; ++k)
      s.translation[k] = placement.middle[k] + ratio * (s.translation[k] - placement.middle[k]);
    s.scale = scale;
    return s;
  }

  Task task_;
};

// Whether two placements do nearly the same.
bool alike(const Placement& a, const Placement& b, double size) {
  constexpr double angle = 15, ratio = 1.1, distance = 0.05;
  const double scales = a.to_face.scale / b.to_face.scale;
  if (degrees_apart(a.to_face, b.to_face) > angle || scales > ratio || scales < 1 / ratio) return false;
  const Similarity between = after(a.to_face, b.to_face.inverse());
  const Vector3 middle = {static_cast<float>(b.middle[0]), static_cast<float>(b.middle[1]),
                          static_cast<float>(b.middle[2])};
  return length(between(middle) - middle) < distance * size;
}

// The best ones, of those that are alike the best.
void select(std::vector<Placement>& placements, std::size_t most, double size) {
  std::ranges::stable_sort(placements, {}, &Placement::score);
  std::vector<Placement> selected;
  for (const Placement& placement : placements) {
    if (selected.size() == most) break;
    const bool known = std::ranges::any_of(selected, [&](const Placement& s) { return alike(placement, s, size); });
    if (!known) selected.push_back(placement);
  }
  placements = std::move(selected);
}

// The same, turned about the middle of its pairs.
Placement turned(Placement placement, std::size_t axis, double degrees) {
  const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
  Similarity turn;
  const std::size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
  turn.rotation[4 * a] = turn.rotation[4 * b] = c;
  turn.rotation[3 * a + b] = -s;
  turn.rotation[3 * b + a] = s;
  const std::array<double, 3>& m = placement.middle;
  turn.translation[a] = m[a] - c * m[a] + s * m[b];
  turn.translation[b] = m[b] - s * m[a] - c * m[b];
  placement.to_face = after(turn, placement.to_face);
  return placement;
}

// The same, scaled about the middle of its pairs.
Placement scaled(Placement placement, double ratio) {
  Similarity larger;
  larger.scale = ratio;
  for (std::size_t k = 0; k < 3; ++k) larger.translation[k] = (1 - ratio) * placement.middle[k];
  placement.to_face = after(larger, placement.to_face);
  return placement;
}

// Few points have many places that are best nearby only: begins again from the best one, turned a little.
Placement shaken(Placement best, const Aligner& aligner, int steps, const Parallel& parallel) {
  constexpr int most_rounds = 6;
  constexpr double degrees[] = {-8, -3, 3, 8};
  for (int round = 0; round < most_rounds; ++round) {
    std::vector<Placement> placements;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const double angle : degrees) placements.push_back(turned(best, axis, angle));
    if (!aligner.fixed_scale())
      for (const double ratio : {0.95, 1.05}) placements.push_back(scaled(best, ratio));
    parallel_for(parallel, placements.size(),
                 [&](std::size_t i, std::size_t) { placements[i] = aligner.refine(placements[i], steps); });
    const Placement& found = *std::ranges::min_element(placements, {}, &Placement::score);
    if (!(found.score < 0.999 * best.score)) break;
    best = found;
  }
  return best;
}

Alignment best_of(const std::vector<Similarity>& guesses, const Aligner& aligner, bool few_points,
                  const Parallel& parallel) {
  constexpr int first_steps = 4, further_steps = 25, rival_steps = 15, last_steps = 60;
  constexpr double same_orientation = 30;  // degrees
  std::vector<Placement> placements;
  for (const Similarity& guess : guesses) placements.push_back({guess});
  const auto each = [&](const auto& work) {
    parallel_for(parallel, placements.size(), [&](std::size_t i, std::size_t) { work(placements[i]); });
  };
  each([&](Placement& p) { aligner.approach(p, 0); });
  select(placements, most_first, aligner.size());
  each([&](Placement& p) { aligner.approach(p, first_steps); });
  select(placements, most_followed, aligner.size());
  each([&](Placement& p) { aligner.approach(p, further_steps); });
  select(placements, most_refined, aligner.size());
  each([&](Placement& p) { p = aligner.refine(p, rival_steps); });
  std::ranges::stable_sort(placements, {}, &Placement::score);
  placements.front() = aligner.refine(placements.front(), last_steps);
  if (few_points) placements.front() = shaken(placements.front(), aligner, last_steps, parallel);
  const Placement& best = placements.front();
  if (!std::isfinite(best.score))
    fail(Status::bad_data, "nothing of the target comes near the face in any orientation");
  Alignment alignment{best.to_face, best.rms, best.kept, INFINITY};
  for (const Placement& other : placements)
    if (degrees_apart(other.to_face, best.to_face) > same_orientation) {
      alignment.rival = other.score / std::max(best.score, 1e-12);
      break;
    }
  return alignment;
}

// The scale that options say, if any.
std::optional<double> given_scale(const AlignmentOptions& options) {
  if (options.scale) return options.scale;
  return options.start ? std::optional(options.start->scale) : std::nullopt;
}

}  // namespace

Alignment align_surfaces(const SampledSurface& other, const SampledSurface& face, const AlignmentOptions& options) {
  const FindPairs find = [&](const Similarity& to_face, bool all) {
    const std::size_t stride = all ? 1 : std::max<std::size_t>(1, face.samples.points.size() / coarse_samples);
    std::vector<Vector3> points, normals;
    for (std::size_t i = 0; i < other.samples.points.size(); i += stride) {
      points.push_back(other.samples.points[i]);
      normals.push_back(other.samples.normals[i]);
    }
    return Directions{pairs_with_face(points, normals, to_face, face), pairs_with_other(other, to_face, face, stride)};
  };
  constexpr double most_ratio = 4;
  const std::optional<double> scale = given_scale(options);
  const double middle = scale.value_or(face.diagonal / other.diagonal),
               range = scale ? options.scale_range : most_ratio;
  const Aligner aligner({.find = find,
                         .least_kept = 0.3,
                         .least = middle / range,
                         .most = middle * range,
                         .first_free = !scale,
                         .size = face.diagonal});
  if (options.start) return best_of({*options.start}, aligner, false, options.parallel);
  std::vector<Similarity> rotations = axis_rotations();
  for (const Similarity& s : principal_rotations(other.samples.points, face.samples.points)) rotations.push_back(s);
  return best_of(guesses_by_box(rotations, other.samples.points, face.box, scale), aligner, false, options.parallel);
}

Alignment align_points(std::span<const Vector3> points, const SampledSurface& face, const std::string& up_axis,
                       double height, const AlignmentOptions& options) {
  if (points.size() < 4)
    fail(Status::bad_data, "%zu markers cannot be aligned with a face: 4 are needed", points.size());
  const std::optional<double> scale = given_scale(options);
  if (!scale) fail(Status::invalid_argument, "markers are aligned at a known scale");
  const FindPairs find = [&](const Similarity& to_face, bool) {
    return Directions(1, pairs_with_face(points, {}, to_face, face, static_cast<float>(height)));
  };
  // With fewer, seven points of 24 would fit anything.
  const Aligner aligner({.find = find,
                         .least_kept = 0.6,
                         .least = *scale / options.scale_range,
                         .most = *scale * options.scale_range,
                         .size = face.diagonal});
  if (options.start) return best_of({*options.start}, aligner, true, options.parallel);
  return best_of(guesses_in_front(axis_rotations(), points, face.box, up_axis, *scale), aligner, true,
                 options.parallel);
}

double likely_metres_per_unit(std::span<const Vector3> points) {
  constexpr double usual = 0.2;  // metres, of the diagonal of the markers' box
  const BoundingBox box = box_of(points);
  const double size = length(box.high - box.low);
  double best = 1;
  for (const double metres : {1.0, 0.01, 0.001})
    if (std::abs(std::log(size * metres / usual)) < std::abs(std::log(size * best / usual))) best = metres;
  return best;
}

}  // namespace fb::tool
