#include "bake/analysis/live/corrective_search.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "bake/analysis/blendshape_parts.h"
#include "bake/analysis/corrective_fit.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Poses whose residuals are held at once: 37 MB of 6,000 vertices, but no more than 128 MiB.
constexpr std::size_t sampled_poses_in_memory = 512, sampled_bytes_in_memory = std::size_t{1} << 27;
constexpr std::size_t most_inner_pairs = 10000;  // candidates up to which a position inside the ranges is tried too
// Beyond pairs, candidates are ranked in batches of so many for every corrective wanted: all by one pose, some of them
// by their subsets too. The next batch is ranked while fewer interact than are wanted. On Aura, where few do, ten
// batches and 64 differences of each control found 44 triples and 4 quads with each of the seeds 2, 3 and 5; one batch
// and 16 differences 40 and 2 with seed 2 (bench_analysis librig_aura.so 1600 400 0 SEED).
constexpr std::size_t ranked_by_pose = 10, ranked_by_subsets = 2, most_batches = 10;
constexpr std::size_t most_tents = 3;  // of a side of a control, as factors
// Residual motion below this part of the tolerance counts as none.
constexpr double negligible = 0.25;

double square_of(const float* d) {
  return double(d[0]) * d[0] + double(d[1]) * d[1] + double(d[2]) * d[2];
}

std::vector<std::uint32_t> without(const std::vector<std::uint32_t>& controls, std::size_t k) {
  std::vector<std::uint32_t> fewer = controls;
  fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(k));
  return fewer;
}

// Features a control may enter a corrective as, the simplest first: across rest, each side, their squares, and tents at
// the knots of its curve, or at the middle of the side. Those of a curve that jumps begin with its steps.
std::vector<std::uint32_t> factors(std::vector<Feature>& features, const Control& control, std::uint32_t index,
                                   const ControlCurve& curve) {
  std::vector<std::uint32_t> list;
  for (const Feature& step : curve.steps) list.push_back(add_feature(features, step));
  const auto square = [&](std::uint32_t f) {
    return add_feature(features, {Feature::Kind::product, 0, 1, 0, 0, f, f});
  };
  if (has_side(control, true) && has_side(control, false)) {
    list.push_back(add_feature(features, across(control, index)));
    list.push_back(square(list.back()));
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

std::size_t active_count(std::span<const std::uint8_t> point) {
  return point.size() - static_cast<std::size_t>(std::count(point.begin(), point.end(), 0));
}

// All lists whose element k is in 1..counts[k].
std::vector<std::vector<std::uint8_t>> combinations(const std::vector<std::size_t>& counts) {
  std::vector<std::vector<std::uint8_t>> points = {{}};
  for (const std::size_t count : counts) {
    std::vector<std::vector<std::uint8_t>> longer;
    for (const std::vector<std::uint8_t>& point : points)
      for (std::uint8_t k = 1; k <= count; ++k) {
        longer.push_back(point);
        longer.back().push_back(k);
      }
    points = std::move(longer);
  }
  return points;
}

// The points and what they become with some controls at rest, of which `fewest` are active; fewer active ones first.
std::vector<std::vector<std::uint8_t>> with_subsets(const std::vector<std::vector<std::uint8_t>>& full_points,
                                                    std::size_t fewest) {
  std::vector<std::vector<std::uint8_t>> points;
  for (const std::vector<std::uint8_t>& full : full_points)
    for (std::uint32_t rested = 0; rested < 1u << full.size(); ++rested) {
      std::vector<std::uint8_t> point = full;
      for (std::size_t k = 0; k < point.size(); ++k)
        if (rested >> k & 1) point[k] = 0;
      if (active_count(point) >= fewest) points.push_back(point);
    }
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return std::pair(active_count(a), a) < std::pair(active_count(b), b); });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

// Subtracts from the residual of every point those of its subsets: the differences of an anchored expansion.
void subtract_subsets(const std::vector<std::vector<std::uint8_t>>& points, std::span<std::vector<float>> residuals) {
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = 0; j < i && active_count(points[j]) < active_count(points[i]); ++j) {
      bool subset = true;
      for (std::size_t k = 0; k < points[i].size(); ++k)
        subset = subset && (points[j][k] == 0 || points[j][k] == points[i][k]);
      if (!subset) continue;
      for (std::size_t k = 0; k < residuals[i].size(); ++k) residuals[i][k] -= residuals[j][k];
    }
}

}  // namespace

CorrectiveSearch::CorrectiveSearch(RigEvaluator& rig, const AnalysisOptions& options,
                                   const std::vector<ControlCurve>& curves, DenseDifferences& dense,
                                   SparseBlendshapes& base, Progress& progress)
    : rig_(rig),
      options_(options),
      curves_(curves),
      dense_(dense),
      base_(base),
      progress_(progress),
      curve_errors_(measure_curves(rig, curves, progress)),
      curve_residual_motion_(difference_motion(dense, base, Statistic::largest, rig)),
      dense_poses_(dense.controls, std::move(dense.displacements), rig.rest_pose(), rig.parallel(), dense.judged) {
  for (const ControlCurve& curve : curves) dense_poses_.add(curve.part, 1);
  note_error("activation curves");
}

void CorrectiveSearch::note_error(const std::string& what) const {
  if (dense_.poses == 0) return;
  const HoldoutSet::Error error = dense_poses_.error();
  progress_.note(
      format("%s: error of the base with 10 to 50 %% of the controls active: %.2e of the diagonal (rms), "
             "%.4f (maximum)",
             what.c_str(), error.rms / rig_.diagonal(), error.max / rig_.diagonal()));
}

// Every pair; beyond, the correctives found so far with each further control.
std::vector<std::vector<std::uint32_t>> CorrectiveSearch::extended_controls(std::size_t order) const {
  const auto width = static_cast<std::uint32_t>(rig_.rest_pose().size());
  std::vector<std::vector<std::uint32_t>> all;
  const auto extend = [&](const std::vector<std::uint32_t>& controls, std::uint32_t c) {
    if (std::find(controls.begin(), controls.end(), c) != controls.end()) return;
    std::vector<std::uint32_t>& longer = all.emplace_back(controls);
    longer.insert(std::lower_bound(longer.begin(), longer.end(), c), c);
  };
  for (std::uint32_t c = 0; c < width; ++c) {
    for (std::uint32_t other = 0; order == 2 && other < c; ++other) extend({other}, c);
    for (const Candidate& corrective : found_)
      if (corrective.controls.size() + 1 == order) extend(corrective.controls, c);
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

// The least residual motion of the controls at a vertex bounds what they do together there: candidates are ranked by
// its square, summed over vertices, and those whose controls share no vertex are left out.
std::vector<CorrectiveSearch::Candidate> CorrectiveSearch::candidates(std::size_t order) const {
  const std::size_t width = rig_.rest_pose().size(), vertices = rig_.coordinate_count() / 3;
  std::vector<std::vector<std::uint32_t>> all = extended_controls(order);
  // What the base leaves over now ranks best, but the differences may have missed a rare combination.
  const std::vector<float> residual_motion =
      order == 2 ? curve_residual_motion_ : difference_motion(dense_, base_, Statistic::largest, rig_);
  const auto threshold = static_cast<float>(negligible * options_.corrective_tolerance);
  std::vector<std::vector<std::uint32_t>> moved(width);  // vertices with residual motion of each control's curve
  for (std::size_t c = 0; c < width; ++c)
    for (std::uint32_t v = 0; v < vertices; ++v)
      if (curve_residual_motion_[c * vertices + v] > threshold) moved[c].push_back(v);
  const auto shared = [&](const std::vector<float>& motion, const std::vector<std::uint32_t>& controls) {
    double score = 0;
    for (const std::uint32_t v : moved[controls[0]]) {
      float least = motion[controls[0] * vertices + v];
      for (const std::uint32_t c : controls) least = std::min(least, motion[c * vertices + v]);
      if (least > threshold) score += double(least) * least;
    }
    return score;
  };
  std::vector<Candidate> scored(all.size());
  parallel_for(rig_.parallel(), all.size(), [&](std::size_t i, std::size_t) {
    scored[i].score = shared(residual_motion, all[i]) + 1e-4 * shared(curve_residual_motion_, all[i]);
    scored[i].controls = std::move(all[i]);
  });
  std::erase_if(scored, [](const Candidate& candidate) { return candidate.score == 0; });
  std::stable_sort(scored.begin(), scored.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  return scored;
}

// All combinations of the ends of ranges; one end of controls whose curve is smooth through rest, which is enough to
// rank by. `inner`: and one point inside the ranges.
CorrectiveSearch::GridPoints CorrectiveSearch::range_ends(const Candidate& candidate, bool inner) const {
  std::vector<std::size_t> counts;
  GridPoint inside;
  for (const std::uint32_t c : candidate.controls) {
    const std::vector<double>& positions = curve_errors_[c].positions;
    const auto sides = static_cast<std::size_t>(
        std::count_if(positions.begin(), positions.end(), [](double p) { return std::abs(p) == 1; }));
    counts.push_back(curves_[c].smooth ? 1 : sides);
    inside.push_back(static_cast<std::uint8_t>(std::min(sides + 1, positions.size())));
  }
  GridPoints points = combinations(counts);
  if (inner) points.push_back(inside);
  return points;
}

CorrectiveSearch::GridPoints CorrectiveSearch::full_grid(const Candidate& candidate) const {
  const std::size_t order = candidate.controls.size(), most = order == 2 ? 8 : order == 3 ? 3 : 2;
  std::vector<std::size_t> counts;
  for (const std::uint32_t c : candidate.controls) counts.push_back(std::min(most, curve_errors_[c].positions.size()));
  return combinations(counts);
}

void CorrectiveSearch::set_pose(const Candidate& candidate, const GridPoint& point, std::span<float> pose) const {
  for (std::size_t k = 0; k < point.size(); ++k) {
    const std::uint32_t c = candidate.controls[k];
    if (point[k] > 0) pose[c] = value_at(rig_.schema().controls[c], curve_errors_[c].positions[point[k] - 1]);
  }
}

// Rig minus base at all points of some candidates, without the errors of the curves.
std::vector<std::vector<float>> CorrectiveSearch::evaluate_residuals(std::span<const Candidate> candidates,
                                                                     std::span<const GridPoints> points_of_each,
                                                                     EvaluationStage& stage) {
  std::vector<std::pair<std::size_t, std::size_t>> poses;  // candidate, point
  for (std::size_t c = 0; c < points_of_each.size(); ++c)
    for (std::size_t i = 0; i < points_of_each[c].size(); ++i) poses.emplace_back(c, i);
  std::vector<std::vector<float>> residuals(poses.size());
  rig_.evaluate_each(
      poses.size(), stage,
      [&](std::size_t i, std::span<float> pose) {
        set_pose(candidates[poses[i].first], points_of_each[poses[i].first][poses[i].second], pose);
      },
      [&](std::size_t i, std::span<const float> pose, std::span<float> displacement) {
        const Candidate& candidate = candidates[poses[i].first];
        const GridPoint& point = points_of_each[poses[i].first][poses[i].second];
        base_.add(pose, rig_.rest_pose(), 1, -1, displacement);
        for (std::size_t k = 0; k < point.size(); ++k)
          if (point[k] > 0) add_scaled(curve_errors_[candidate.controls[k]].errors[point[k] - 1], -1, displacement);
        residuals[i].assign(displacement.begin(), displacement.end());
      });
  return residuals;
}

template <class PointsOf, class Visit>
void CorrectiveSearch::evaluate_candidates(const char* stage_name, std::span<Candidate> candidates, std::size_t fewest,
                                           const PointsOf& points_of, const Visit& visit) {
  std::vector<GridPoints> samplings;
  std::size_t total = 0;
  for (const Candidate& candidate : candidates) {
    samplings.push_back(with_subsets(points_of(candidate), fewest));
    if (total + samplings.back().size() > rig_.remaining()) {
      samplings.pop_back();
      break;
    }
    total += samplings.back().size();
  }
  if (samplings.size() < candidates.size())
    progress_.note(format("the budget of rig calls leaves %zu of %zu candidates out of \"%s\"",
                          candidates.size() - samplings.size(), candidates.size(), stage_name));
  EvaluationStage stage(progress_, Phase::analysis, stage_name, total);
  const std::size_t most =
      std::min(sampled_poses_in_memory, sampled_bytes_in_memory / (sizeof(float) * rig_.coordinate_count()));
  for (std::size_t begin = 0; begin < samplings.size();) {
    std::vector<std::size_t> first;  // residual of each candidate of this block
    std::size_t end = begin, poses = 0;
    for (; end < samplings.size() && (end == begin || poses + samplings[end].size() <= most); ++end) {
      first.push_back(poses);
      poses += samplings[end].size();
    }
    std::vector<std::vector<float>> residuals = evaluate_residuals(
        candidates.subspan(begin, end - begin), std::span(samplings).subspan(begin, end - begin), stage);
    parallel_for(rig_.parallel(), end - begin, [&](std::size_t i, std::size_t) {
      Candidate& candidate = candidates[begin + i];
      const GridPoints& points = samplings[begin + i];
      const std::span<std::vector<float>> own = std::span(residuals).subspan(first[i], points.size());
      subtract_subsets(points, own);
      const auto full = static_cast<std::size_t>(std::count_if(points.begin(), points.end(), [&](const auto& point) {
        return active_count(point) == candidate.controls.size();
      }));
      visit(candidate, std::span(points).last(full), own.last(full));
    });
    begin = end;
  }
}

// Products and minima of factors of all controls: for pairs those of both; beyond, correctives already found for all
// controls but one, or their plain product, times factors of that one.
std::vector<std::uint32_t> CorrectiveSearch::composed_features(const Candidate& candidate,
                                                               std::vector<Feature>& features) const {
  const RigSchema& schema = rig_.schema();
  const auto factors_of = [&](std::uint32_t c) { return factors(features, schema.controls[c], c, curves_[c]); };
  const std::size_t order = candidate.controls.size();
  std::vector<std::uint32_t> all;
  for (std::size_t k = 0; k < (order == 2 ? 1 : order); ++k) {
    const std::vector<std::uint32_t> others = without(candidate.controls, k);
    std::vector<std::uint32_t> of_others = factors_of(others[0]);
    if (others.size() > 1) {
      const auto known = std::find_if(found_.begin(), found_.end(),
                                      [&](const Candidate& corrective) { return corrective.controls == others; });
      std::uint32_t plain = of_others[0];
      for (std::size_t i = 1; i < others.size(); ++i)
        plain = compose(features, std::vector{plain}, std::vector{factors_of(others[i])[0]})[0];
      of_others = {plain};
      if (known != found_.end())
        for (const SparseShape& shape : known->part.shapes)
          of_others.push_back(import_feature(features, known->part.features, shape.feature));
    }
    const std::vector<std::uint32_t> composed = compose(features, of_others, factors_of(candidate.controls[k]));
    all.insert(all.end(), composed.begin(), composed.end());
  }
  std::vector<std::uint32_t> unique;
  for (const std::uint32_t feature : all)
    if (std::find(unique.begin(), unique.end(), feature) == unique.end()) unique.push_back(feature);
  return unique;
}

void CorrectiveSearch::fit(Candidate& candidate, std::span<const GridPoint> points,
                           std::span<const std::vector<float>> differences) const {
  std::vector<Feature> features;
  const std::vector<std::uint32_t> composed = composed_features(candidate, features);
  std::vector<float> poses;
  for (const GridPoint& point : points) {
    poses.insert(poses.end(), rig_.rest_pose().begin(), rig_.rest_pose().end());
    set_pose(candidate, point, std::span(poses).last(rig_.rest_pose().size()));
  }
  const double tolerance = options_.corrective_tolerance * rig_.diagonal();
  candidate.part =
      fit_corrective(features, composed, poses, rig_.rest_pose(), differences, {tolerance, tolerance / 20});
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pose = std::span(poses).subspan(i * rig_.rest_pose().size(), rig_.rest_pose().size());
    std::vector<float> off = differences[i];
    candidate.part.add(pose, rig_.rest_pose(), 1, -1, off);
    double worst = 0;
    for (std::size_t k = 0; k < off.size(); k += 3) worst = std::max(worst, square_of(off.data() + k));
    if (std::sqrt(worst) <= candidate.misfit) continue;
    candidate.misfit = std::sqrt(worst);
    candidate.misfit_pose.assign(pose.begin(), pose.end());
  }
}

std::vector<CorrectiveSearch::Misfit> CorrectiveSearch::misfits(double least) const {
  std::map<std::uint32_t, const Candidate*> worst;
  for (const Candidate& corrective : found_)
    for (const std::uint32_t c : corrective.controls) {
      const Candidate*& of_control = worst[c];
      if (corrective.misfit > (of_control ? of_control->misfit : least)) of_control = &corrective;
    }
  std::vector<Misfit> misfits;
  for (const auto& [control, corrective] : worst)
    if (corrective) misfits.push_back({control, corrective->misfit_pose});
  return misfits;
}

void CorrectiveSearch::weigh(Candidate& candidate, std::span<const std::vector<float>> differences) const {
  const std::size_t surface = rig_.rest().first_joint_coordinate();
  double of_surface = 0, of_joints = 0;  // largest squares
  candidate.energy = 0;
  for (const std::vector<float>& d : differences) {
    double sum = 0;
    for (std::size_t i = 0; i < d.size(); i += 3) {
      const double squares = square_of(d.data() + i);
      sum += squares;
      double& largest = i < surface ? of_surface : of_joints;
      largest = std::max(largest, squares);
    }
    candidate.energy = std::max(candidate.energy, sum / (rig_.diagonal() * rig_.diagonal()));
  }
  candidate.distance = std::sqrt(std::max(of_surface, of_joints)) / rig_.diagonal();
  candidate.surface = std::sqrt(of_surface) / rig_.diagonal() > options_.corrective_tolerance;
}

std::size_t CorrectiveSearch::with_joints(std::size_t most) const {
  const auto of_surface = std::size_t(std::ranges::count_if(found_, [](const Candidate& one) { return one.surface; }));
  const bool mostly_surface = 2 * of_surface > found_.size();
  return rig_.rest().driven.empty() || mostly_surface ? most : options_.joint_factor * most;
}

void CorrectiveSearch::limit(std::vector<Candidate>& candidates, std::size_t most) const {
  std::size_t moving = 0;
  std::erase_if(candidates, [&](const Candidate& candidate) { return candidate.surface && ++moving > most; });
  if (candidates.size() > with_joints(most)) candidates.resize(with_joints(most));
}

void CorrectiveSearch::rank(const char* stage, std::vector<Candidate>& candidates, std::size_t fewest) {
  const bool inner = candidates.size() <= most_inner_pairs && fewest == 2;
  evaluate_candidates(
      stage, candidates, fewest,
      [&](const Candidate& candidate) { return range_ends(candidate, inner && candidate.controls.size() == 2); },
      [&](Candidate& candidate, std::span<const GridPoint>, std::span<const std::vector<float>> differences) {
        weigh(candidate, differences);
      });
  std::erase_if(candidates,
                [&](const Candidate& candidate) { return candidate.distance <= options_.corrective_tolerance; });
  std::stable_sort(candidates.begin(), candidates.end(), stronger);
}

// First by what all controls at once leave over, then by the part that no subset of them accounts for.
std::size_t CorrectiveSearch::rank_in_batches(std::vector<Candidate>& candidates, std::size_t most) {
  const std::size_t order = candidates.empty() ? 0 : candidates[0].controls.size();
  std::vector<Candidate> interacting;
  std::size_t ranked = 0;
  for (std::size_t i = 0; i < most_batches && ranked < candidates.size() && interacting.size() < most; ++i) {
    const std::size_t end = std::min(candidates.size(), ranked + ranked_by_pose * most);
    std::vector<Candidate> batch(std::make_move_iterator(candidates.begin() + std::ptrdiff_t(ranked)),
                                 std::make_move_iterator(candidates.begin() + std::ptrdiff_t(end)));
    ranked = end;
    rank("ranking correctives", batch, order);
    if (batch.size() > ranked_by_subsets * most) batch.resize(ranked_by_subsets * most);
    rank("ranking correctives by subsets", batch, 2);
    std::move(batch.begin(), batch.end(), std::back_inserter(interacting));
  }
  std::stable_sort(interacting.begin(), interacting.end(), stronger);
  candidates = std::move(interacting);
  return ranked;
}

void CorrectiveSearch::find(std::size_t order, std::size_t most) {
  std::vector<Candidate> all = candidates(order);
  std::size_t evaluated = all.size();
  if (order == 2)
    rank("ranking correctives", all, order);
  else
    evaluated = rank_in_batches(all, with_joints(most));
  const std::size_t interacting = all.size();
  limit(all, most);
  const std::size_t fitted = fit_all(std::move(all));
  note_error(format("correctives of %zu controls: %zu candidates, %zu interact, %zu fitted", order, evaluated,
                    interacting, fitted));
}

std::size_t CorrectiveSearch::fit_all(std::vector<Candidate> candidates) {
  evaluate_candidates(
      "fitting correctives", candidates, 2, [&](const Candidate& candidate) { return full_grid(candidate); },
      [&](Candidate& candidate, std::span<const GridPoint> points, std::span<const std::vector<float>> differences) {
        if (candidate.energy == 0) weigh(candidate, differences);
        fit(candidate, points, differences);
      });
  std::erase_if(candidates, [](const Candidate& candidate) { return candidate.part.shapes.empty(); });
  std::vector<const SparseBlendshapes*> parts;
  for (const Candidate& corrective : candidates) {
    parts.push_back(&corrective.part);
    dense_poses_.add(corrective.part, 1);
  }
  append(base_, parts);
  std::move(candidates.begin(), candidates.end(), std::back_inserter(found_));
  return parts.size();
}

bool CorrectiveSearch::has(const std::vector<std::uint32_t>& controls) const {
  return std::any_of(found_.begin(), found_.end(), [&](const Candidate& c) { return c.controls == controls; });
}

std::size_t CorrectiveSearch::add(std::span<const std::vector<std::uint32_t>> missed) {
  std::size_t added = 0;
  for (std::size_t order = 2; order <= 4; ++order) {
    std::set<std::vector<std::uint32_t>> exact, subsets;
    for (const std::vector<std::uint32_t>& controls : missed)
      for (std::uint32_t chosen = 1; chosen < 1u << controls.size(); ++chosen) {
        std::vector<std::uint32_t> subset;
        for (std::size_t k = 0; k < controls.size(); ++k)
          if (chosen >> k & 1) subset.push_back(controls[k]);
        if (subset.size() == order && !has(subset)) (subset == controls ? exact : subsets).insert(subset);
      }
    std::vector<Candidate> all;
    for (const std::vector<std::uint32_t>& controls : subsets)
      if (!exact.contains(controls)) all.emplace_back().controls = controls;
    rank("ranking subsets of missed correctives", all, 2);
    // Those missed may act inside the ranges only, where ranking does not look.
    for (const std::vector<std::uint32_t>& controls : exact) all.emplace_back().controls = controls;
    added += fit_all(std::move(all));
  }
  return added;
}

std::vector<Corrective> CorrectiveSearch::prune() {
  // The weakest first: those of most controls, then those of least energy.
  std::stable_sort(found_.begin(), found_.end(), [](const Candidate& a, const Candidate& b) {
    return std::pair(a.controls.size(), b.energy) > std::pair(b.controls.size(), a.energy);
  });
  std::vector<const SparseBlendshapes*> parts;
  for (const Candidate& corrective : found_) parts.push_back(&corrective.part);
  const std::vector<bool> helpful = dense_poses_.prune(parts);
  std::vector<Candidate> kept;
  for (std::size_t i = 0; i < found_.size(); ++i)
    if (helpful[i]) kept.push_back(std::move(found_[i]));
  const std::size_t pruned = found_.size() - kept.size();
  std::stable_sort(kept.begin(), kept.end(), stronger);
  parts.clear();
  for (const ControlCurve& curve : curves_) parts.push_back(&curve.part);
  for (const Candidate& corrective : kept) parts.push_back(&corrective.part);
  base_ = {};
  const std::vector<std::vector<std::uint32_t>> features = append(base_, parts);
  std::vector<Corrective> correctives;
  for (std::size_t i = 0; i < kept.size(); ++i)
    correctives.push_back({kept[i].controls, kept[i].energy, features[curves_.size() + i]});
  if (pruned > 0) note_error(format("%zu correctives pruned", pruned));
  found_.clear();
  return correctives;
}

}  // namespace fb::bake
