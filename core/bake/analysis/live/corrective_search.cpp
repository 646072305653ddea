#include "bake/analysis/live/corrective_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/analysis/blendshape_parts.h"
#include "bake/analysis/corrective_fit.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t block_poses = 512;  // whose displacements are held at once: 37 MB of 6,000 vertices
constexpr std::size_t few_pairs = 10000;  // candidates up to which a place inside the ranges is tried too
constexpr std::size_t tries_a_term =
    10;                                // candidates tried for every tuple wanted, beyond pairs; a fifth of them twice
constexpr std::size_t most_tents = 3;  // of a side of a control, in terms
constexpr double still = 0.25;         // of the tolerance: residual motion that is none

double square_of(const float* d) {
  return double(d[0]) * d[0] + double(d[1]) * d[1] + double(d[2]) * d[2];
}

std::vector<std::uint32_t> without(const std::vector<std::uint32_t>& tuple, std::size_t k) {
  std::vector<std::uint32_t> fewer = tuple;
  fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(k));
  return fewer;
}

// What a control may enter terms as, the simplest first: across rest, each side, their squares, and tents at the knots
// of its curve, or half way.
std::vector<std::uint32_t> factors(std::vector<Feature>& features, const Control& control, std::uint32_t index,
                                   const ControlCurve& curve) {
  std::vector<std::uint32_t> list;
  const auto square = [&](std::uint32_t f) {
    return add_feature(features, {Feature::Kind::product, 0, 1, 0, 0, f, f});
  };
  if (has_side(control, true) && has_side(control, false)) {
    list.push_back(add_feature(features, across(control, index)));
    list.push_back(square(list[0]));
  }
  for (const bool up : {true, false}) {
    if (!has_side(control, up)) continue;
    const Feature ramp = side_ramp(control, index, up);
    list.push_back(add_feature(features, ramp));
    list.push_back(square(list.back()));
    std::vector<double> knots = {0, up ? 1.0 : -1.0};
    for (const double knot : curve.knots)
      if ((knot > 0) == up && knots.size() < most_tents + 2) knots.push_back(knot);
    if (knots.size() == 2) knots.push_back(knots[1] / 2);
    std::sort(knots.begin(), knots.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
    for (std::size_t k = 1; k + 1 < knots.size(); ++k)
      list.push_back(add_feature(features, tent(control, index, knots[k - 1], knots[k], knots[k + 1])));
  }
  return list;
}

}  // namespace

CorrectiveSearch::CorrectiveSearch(RigEvaluator& rig, const AnalysisOptions& options,
                                   const std::vector<ControlCurve>& curves, const DenseDifferences& dense,
                                   SparseBlendshapes& base, Progress& progress)
    : rig_(rig),
      options_(options),
      curves_(curves),
      dense_(dense),
      base_(base),
      progress_(progress),
      curve_errors_(measure_curves(rig, curves, progress)),
      single_left_(difference_motion(dense, base, Over::largest, rig)),
      held_(dense.controls, dense.displacements, rig.rest_pose(), rig.parallel()) {
  for (const ControlCurve& curve : curves) held_.add(curve.part, 1);
  note_error("single controls");
}

void CorrectiveSearch::note_error(const std::string& what) const {
  if (dense_.poses == 0) return;
  const HoldoutSet::Error error = held_.error();
  progress_.note(
      format("%s: with 10 to 50 %% of the controls on, the base is off by %.2e (rms) and %.4f (most) of "
             "the diagonal",
             what.c_str(), error.rms / rig_.diagonal(), error.max / rig_.diagonal()));
}

// Every pair; beyond, what interacts already with each further control. What all controls of a tuple leave over at a
// vertex bounds what they do together there: they are ranked by that, and those that share no vertex are left out.
std::vector<CorrectiveSearch::Tuple> CorrectiveSearch::candidates(std::size_t order) const {
  const auto width = static_cast<std::uint32_t>(rig_.rest_pose().size());
  const std::size_t vertices = rig_.coordinate_count() / 3;
  std::vector<std::vector<std::uint32_t>> tuples;
  const auto extend = [&](const std::vector<std::uint32_t>& tuple, std::uint32_t c) {
    if (std::find(tuple.begin(), tuple.end(), c) != tuple.end()) return;
    std::vector<std::uint32_t>& longer = tuples.emplace_back(tuple);
    longer.insert(std::lower_bound(longer.begin(), longer.end(), c), c);
  };
  for (std::uint32_t c = 0; c < width; ++c) {
    for (std::uint32_t other = 0; order == 2 && other < c; ++other) extend({other}, c);
    for (const Tuple& known : found_)
      if (known.controls.size() + 1 == order) extend(known.controls, c);
  }
  std::sort(tuples.begin(), tuples.end());
  tuples.erase(std::unique(tuples.begin(), tuples.end()), tuples.end());
  // Motion the base of today leaves over tells most, but toggles may have missed a rare combination.
  const std::vector<float> left = order == 2 ? single_left_ : difference_motion(dense_, base_, Over::largest, rig_);
  const auto threshold = static_cast<float>(still * options_.corrective_tolerance);
  std::vector<std::vector<std::uint32_t>> moved(width);  // by each control, as curves leave it over
  for (std::uint32_t c = 0; c < width; ++c)
    for (std::uint32_t v = 0; v < vertices; ++v)
      if (single_left_[c * vertices + v] > threshold) moved[c].push_back(v);
  const auto shared = [&](const std::vector<float>& motion, const std::vector<std::uint32_t>& tuple) {
    double score = 0;
    for (const std::uint32_t v : moved[tuple[0]]) {
      float least = motion[tuple[0] * vertices + v];
      for (const std::uint32_t c : tuple) least = std::min(least, motion[c * vertices + v]);
      if (least > threshold) score += double(least) * least;
    }
    return score;
  };
  std::vector<Tuple> scored(tuples.size());
  parallel_for(rig_.parallel(), tuples.size(), [&](std::size_t t, std::size_t) {
    scored[t].score = shared(left, tuples[t]) + 1e-4 * shared(single_left_, tuples[t]);
    scored[t].controls = std::move(tuples[t]);
  });
  std::erase_if(scored, [](const Tuple& tuple) { return tuple.score == 0; });
  std::stable_sort(scored.begin(), scored.end(), [](const Tuple& a, const Tuple& b) { return a.score > b.score; });
  return scored;
}

// All combinations of the ends; of controls whose curve runs smoothly through rest, one end tells enough to rank by.
std::vector<CorrectiveSearch::Point> CorrectiveSearch::ends(const Tuple& tuple, bool inner) const {
  std::vector<Point> points = {{}};
  Point inside;
  for (const std::uint32_t c : tuple.controls) {
    const std::vector<double>& places = curve_errors_[c].places;
    const std::size_t sides = std::count_if(places.begin(), places.end(), [](double p) { return std::abs(p) == 1; });
    std::vector<Point> longer;
    for (const Point& point : points)
      for (std::uint8_t end = 1; end <= (curves_[c].smooth ? 1 : sides); ++end) {
        longer.push_back(point);
        longer.back().push_back(end);
      }
    points = std::move(longer);
    inside.push_back(static_cast<std::uint8_t>(std::min(sides + 1, places.size())));
  }
  if (inner) points.push_back(inside);
  return points;
}

std::vector<CorrectiveSearch::Point> CorrectiveSearch::grid(const Tuple& tuple) const {
  const std::size_t order = tuple.controls.size(), most = order == 2 ? 4 : order == 3 ? 3 : 2;
  std::vector<Point> points = {{}};
  for (const std::uint32_t c : tuple.controls) {
    std::vector<Point> longer;
    for (const Point& point : points)
      for (std::uint8_t place = 1; place <= std::min(most, curve_errors_[c].places.size()); ++place) {
        longer.push_back(point);
        longer.back().push_back(place);
      }
    points = std::move(longer);
  }
  return points;
}

void CorrectiveSearch::fill(const Tuple& tuple, const Point& point, std::span<float> pose) const {
  for (std::size_t k = 0; k < point.size(); ++k) {
    const std::uint32_t c = tuple.controls[k];
    if (point[k] > 0) pose[c] = value_at(rig_.schema().controls[c], curve_errors_[c].places[point[k] - 1]);
  }
}

template <class Points, class Visit>
void CorrectiveSearch::evaluate_tuples(const char* stage, std::span<Tuple> tuples, std::size_t fewest,
                                       const Points& points_of, const Visit& visit) {
  const auto away = [](const Point& point) { return point.size() - std::count(point.begin(), point.end(), 0); };
  struct Asked {
    std::vector<Point> points;  // full ones and what they become with controls at rest, fewer controls first
    std::size_t first = 0;
  };
  std::vector<Asked> asked(tuples.size());
  std::size_t total = 0, affordable = 0;
  for (; affordable < tuples.size(); ++affordable) {
    std::vector<Point>& points = asked[affordable].points;
    for (const Point& full : points_of(tuples[affordable]))
      for (std::uint32_t rested = 0; rested < 1u << full.size(); ++rested) {
        Point point = full;
        for (std::size_t k = 0; k < point.size(); ++k)
          if (rested >> k & 1) point[k] = 0;
        if (std::size_t(away(point)) >= fewest) points.push_back(point);
      }
    std::sort(points.begin(), points.end(),
              [&](const Point& a, const Point& b) { return std::pair(away(a), a) < std::pair(away(b), b); });
    points.erase(std::unique(points.begin(), points.end()), points.end());
    if (total + points.size() > rig_.remaining()) break;
    total += points.size();
  }
  if (affordable < tuples.size())
    progress_.note(format("the budget of rig calls leaves %zu of %zu combinations of controls out of \"%s\"",
                          tuples.size() - affordable, tuples.size(), stage));
  EvaluationStage progress(progress_, stage, total);
  for (std::size_t begin = 0; begin < affordable;) {
    std::size_t end = begin, poses = 0;
    std::vector<std::pair<std::size_t, std::size_t>> asks;  // tuple, point
    for (; end < affordable && (end == begin || poses + asked[end].points.size() <= block_poses); ++end) {
      asked[end].first = poses;
      poses += asked[end].points.size();
      for (std::size_t i = 0; i < asked[end].points.size(); ++i) asks.emplace_back(end, i);
    }
    std::vector<std::vector<float>> left(poses);
    rig_.evaluate_each(
        poses, progress,
        [&](std::size_t i, std::span<float> pose) {
          fill(tuples[asks[i].first], asked[asks[i].first].points[asks[i].second], pose);
        },
        [&](std::size_t i, std::span<const float> pose, std::span<float> displacement) {
          const Tuple& tuple = tuples[asks[i].first];
          const Point& point = asked[asks[i].first].points[asks[i].second];
          base_.add(pose, rig_.rest_pose(), 1, -1, displacement);
          for (std::size_t k = 0; k < point.size(); ++k)
            if (point[k] > 0) add_scaled(curve_errors_[tuple.controls[k]].errors[point[k] - 1], -1, displacement);
          left[i].assign(displacement.begin(), displacement.end());
        });
    parallel_for(rig_.parallel(), end - begin, [&](std::size_t t, std::size_t) {
      const std::vector<Point>& points = asked[begin + t].points;
      const std::span<std::vector<float>> mine(left.data() + asked[begin + t].first, points.size());
      // What fewer of the controls leave over is taken away: the differences of an anchored expansion.
      for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = 0; j < i && away(points[j]) < away(points[i]); ++j) {
          bool part = true;
          for (std::size_t k = 0; k < points[i].size(); ++k)
            part = part && (points[j][k] == 0 || points[j][k] == points[i][k]);
          if (!part) continue;
          for (std::size_t k = 0; k < mine[i].size(); ++k) mine[i][k] -= mine[j][k];
        }
      const std::size_t order = tuples[begin + t].controls.size();
      const std::size_t full = std::count_if(points.begin(), points.end(),
                                             [&](const Point& point) { return std::size_t(away(point)) == order; });
      visit(tuples[begin + t], std::span(points).last(full), mine.last(full));
    });
    begin = end;
  }
}

void CorrectiveSearch::fit(Tuple& tuple, std::span<const Point> points,
                           std::span<const std::vector<float>> differences) const {
  const RigSchema& schema = rig_.schema();
  std::vector<Feature> features;
  std::vector<std::uint32_t> terms;
  const auto factors_of = [&](std::uint32_t c) { return factors(features, schema.controls[c], c, curves_[c]); };
  const std::size_t order = tuple.controls.size();
  for (std::size_t k = 0; k < (order == 2 ? 1 : order); ++k) {
    // Terms already found for the other controls, or their plain product, times what this one may enter as.
    const std::vector<std::uint32_t> others = without(tuple.controls, k);
    std::vector<std::uint32_t> together = factors_of(others[0]);
    if (others.size() > 1) {
      const auto known = std::find_if(found_.begin(), found_.end(),
                                      [&](const Tuple& corrective) { return corrective.controls == others; });
      std::uint32_t plain = together[0];
      for (std::size_t i = 1; i < others.size(); ++i)
        plain = compose(features, std::vector{plain}, std::vector{factors_of(others[i])[0]})[0];
      together = {plain};
      if (known != found_.end())
        for (const SparseShape& shape : known->part.shapes)
          together.push_back(import_feature(features, known->part.features, shape.feature));
    }
    const std::vector<std::uint32_t> composed = compose(features, together, factors_of(tuple.controls[k]));
    terms.insert(terms.end(), composed.begin(), composed.end());
  }
  std::vector<std::uint32_t> unique;
  for (const std::uint32_t term : terms)
    if (std::find(unique.begin(), unique.end(), term) == unique.end()) unique.push_back(term);
  std::vector<float> poses;
  for (const Point& point : points) {
    poses.insert(poses.end(), rig_.rest_pose().begin(), rig_.rest_pose().end());
    fill(tuple, point, std::span(poses).last(rig_.rest_pose().size()));
  }
  const double tolerance = options_.corrective_tolerance * rig_.diagonal();
  tuple.part = fit_corrective(features, unique, poses, rig_.rest_pose(), differences, {tolerance, tolerance / 20});
}

void CorrectiveSearch::rank(const char* stage, std::vector<Tuple>& tuples, std::size_t fewest) {
  const bool inner = tuples.size() <= few_pairs && fewest == 2;
  evaluate_tuples(
      stage, tuples, fewest, [&](const Tuple& tuple) { return ends(tuple, inner && tuple.controls.size() == 2); },
      [&](Tuple& tuple, std::span<const Point>, std::span<const std::vector<float>> differences) {
        tuple.energy = tuple.distance = 0;
        for (const std::vector<float>& d : differences) {
          double sum = 0;
          for (std::size_t i = 0; i < d.size(); i += 3) {
            const double squares = square_of(d.data() + i);
            sum += squares;
            tuple.distance = std::max(tuple.distance, squares);
          }
          tuple.energy = std::max(tuple.energy, sum / (rig_.diagonal() * rig_.diagonal()));
        }
        tuple.distance = std::sqrt(tuple.distance) / rig_.diagonal();
      });
  std::erase_if(tuples, [&](const Tuple& tuple) { return tuple.distance <= options_.corrective_tolerance; });
  std::stable_sort(tuples.begin(), tuples.end(), [](const Tuple& a, const Tuple& b) { return a.energy > b.energy; });
}

void CorrectiveSearch::find(std::size_t order, std::size_t most) {
  std::vector<Tuple> tuples = candidates(order);
  if (order > 2 && tuples.size() > tries_a_term * most) tuples.resize(tries_a_term * most);
  const std::size_t tried = tuples.size();
  // Beyond pairs, first what the base leaves over of all controls at once, then what fewer of them have no part in.
  rank("trying controls together", tuples, order);
  if (order > 2) {
    if (tuples.size() > tries_a_term * most / 5) tuples.resize(tries_a_term * most / 5);
    rank("trying fewer of them", tuples, 2);
  }
  const std::size_t interacting = tuples.size();
  if (tuples.size() > most) tuples.resize(most);
  evaluate_tuples(
      "fitting controls together", tuples, 2, [&](const Tuple& tuple) { return grid(tuple); },
      [&](Tuple& tuple, std::span<const Point> points, std::span<const std::vector<float>> differences) {
        fit(tuple, points, differences);
      });
  std::erase_if(tuples, [](const Tuple& tuple) { return tuple.part.shapes.empty(); });
  std::vector<const SparseBlendshapes*> parts;
  for (const Tuple& tuple : tuples) {
    parts.push_back(&tuple.part);
    held_.add(tuple.part, 1);
  }
  append(base_, parts);
  note_error(format("%zu controls together, %zu tried, %zu interact, terms for %zu", order, tried, interacting,
                    tuples.size()));
  std::move(tuples.begin(), tuples.end(), std::back_inserter(found_));
}

std::vector<Corrective> CorrectiveSearch::finish() {
  // Weaker ones are judged first, among all that are still there; the largest tuples are the weakest.
  std::stable_sort(found_.begin(), found_.end(), [](const Tuple& a, const Tuple& b) {
    return std::pair(a.controls.size(), b.energy) > std::pair(b.controls.size(), a.energy);
  });
  std::vector<const SparseBlendshapes*> parts;
  for (const Tuple& tuple : found_) parts.push_back(&tuple.part);
  const std::vector<bool> helps = held_.judge(parts);
  std::vector<Tuple> kept;
  for (std::size_t t = 0; t < found_.size(); ++t)
    if (helps[t]) kept.push_back(std::move(found_[t]));
  const std::size_t dropped = found_.size() - kept.size();
  std::stable_sort(kept.begin(), kept.end(), [](const Tuple& a, const Tuple& b) { return a.energy > b.energy; });
  parts.clear();
  for (const ControlCurve& curve : curves_) parts.push_back(&curve.part);
  for (const Tuple& tuple : kept) parts.push_back(&tuple.part);
  base_ = {};
  const std::vector<std::vector<std::uint32_t>> features = append(base_, parts);
  std::vector<Corrective> correctives;
  for (std::size_t t = 0; t < kept.size(); ++t)
    correctives.push_back({kept[t].controls, kept[t].energy, features[curves_.size() + t]});
  if (dropped > 0) note_error(format("without %zu combinations of controls that did not help", dropped));
  found_.clear();
  return correctives;
}

}  // namespace fb::bake
