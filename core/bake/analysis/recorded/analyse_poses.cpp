#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "bake/analysis/blendshape_parts.h"
#include "bake/analysis/holdout_set.h"
#include "bake/analysis/jumping_curve.h"
#include "bake/analysis/recorded/recorded_poses.h"
#include "bake/analysis/rig_analysis.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t most_fitted = 6000;         // poses, evenly spaced
constexpr std::size_t most_validation = 400;      // poses; at most a fifth of those with several controls active
constexpr std::size_t validation_run = 8;         // consecutive validation poses
constexpr std::size_t most_alone = 24;            // poses of one control alone, a side
constexpr std::size_t poses_per_corrective = 20;  // fitted poses needed for every pair
constexpr std::size_t poses_per_tent = 20;        // fitted poses needed for a knot at the middle of a side
// Pairs that leave more than this part of the error are left to the networks. On a production rig, where they leave 97
// % with 3,000 poses and 78 % with 9,000, the mse of random poses is 11 and 17 % larger with them; on Aura with 4,000,
// where pairs are most of what single controls leave, that of poses held back is 13 times smaller.
constexpr double worthwhile_pairs = 0.5;
constexpr double ramp_ridge = 1e-4, tent_ridge = 1e-3, pair_ridge = 1e-4;  // at strength 1, see Regression
constexpr double strongest = 1000, strength_step = 3.1622776601683795;     // of regularisation

class RecordedAnalysis {
 public:
  RecordedAnalysis(const PoseSet& poses, const AnalysisOptions& options, const Parallel& parallel, Progress& progress)
      : poses_(poses),
        schema_(poses.source().schema()),
        options_(options),
        parallel_(parallel),
        progress_(progress),
        controls_(poses.controls()),
        rest_(schema_.rest_pose()),
        size_(poses.source().rest().points.size()),
        diagonal_(poses.source().rest().diagonal()),
        curves_(rest_.size()) {}

  RigAnalysis run() {
    if (poses_.size() == 0) fail(Status::invalid_argument, "there are no poses to analyse");
    sort_poses();
    note_resting_controls();
    fit_alone();
    fit_together();
    fit_pairs();
    assemble();
    std::vector<const SparseBlendshapes*> parts;
    for (const ControlCurve& curve : curves_) parts.push_back(&curve.part);
    for (const SparseBlendshapes& part : pairs_) parts.push_back(&part);
    analysis_.motion = part_motion(schema_, parts, size_ / 3, diagonal_, parallel_);
    analysis_.residual_motion =
        residual_by_control(recorded(fitted_, analysis_.base), analysis_.motion, diagonal_, parallel_, progress_);
    return std::move(analysis_);
  }

 private:
  std::span<const float> pose(std::size_t i) const {
    return std::span(controls_).subspan(i * rest_.size(), rest_.size());
  }

  // Finds the poses with one control active; of those with several, which are fitted and which validate the fit.
  void sort_poses() {
    std::vector<std::size_t> mixed;
    alone_.resize(2 * rest_.size());
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      std::size_t count = 0, last = 0;
      for (std::size_t c = 0; c < rest_.size(); ++c)
        if (pose(i)[c] != rest_[c]) ++count, last = c;
      if (count == 1) alone_[2 * last + (pose(i)[last] > rest_[last])].push_back(i);
      if (count > 1) mixed.push_back(i);
    }
    // Validation poses come in short runs, so that neighbours of the same motion are not on both sides.
    const std::size_t validation = std::min(most_validation, mixed.size() / 5),
                      runs = (validation + validation_run - 1) / validation_run;
    std::vector<bool> validates(mixed.size());
    for (std::size_t r = 0; r < runs; ++r)
      for (std::size_t i = 0; i < validation_run; ++i)
        validates[std::min(mixed.size() - 1, r * mixed.size() / runs + i)] = true;
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < mixed.size(); ++i) (validates[i] ? validation_ : others).push_back(mixed[i]);
    const std::size_t fitted = std::min(most_fitted, others.size());
    for (std::size_t i = 0; i < fitted; ++i) fitted_.push_back(others[i * others.size() / fitted]);
  }

  void note_resting_controls() const {
    std::vector<bool> moved(rest_.size());
    for (std::size_t i = 0; i < poses_.size(); ++i)
      for (std::size_t c = 0; c < rest_.size(); ++c)
        if (pose(i)[c] != rest_[c]) moved[c] = true;
    std::size_t never = 0;
    std::string first;
    for (std::size_t c = 0; c < rest_.size(); ++c)
      if (!moved[c] && never++ == 0) first = schema_.controls[c].name;
    if (never > 0)
      progress_.note(
          format("%zu of %zu controls never leave rest in the recorded poses (\"%s\"%s): they will move nothing", never,
                 rest_.size(), first.c_str(), never > 1 ? ", ..." : ""));
  }

  // Fits curves to the poses of one control alone.
  void fit_alone() {
    const CurveLimits limits{options_.curve_tolerance * diagonal_, 1e-6 * diagonal_, options_.max_knots};
    std::vector<std::uint32_t> controls;
    for (std::uint32_t c = 0; c < rest_.size(); ++c)
      if (!alone_[2 * c].empty() || !alone_[2 * c + 1].empty()) controls.push_back(c);
    progress_.begin(Phase::analysis, "fitting controls recorded alone", controls.size());
    for (std::size_t i = 0; i < controls.size(); ++i) {
      const std::uint32_t c = controls[i];
      const CurveSamples samples = read_alone(c);
      const std::vector<Jump> jumps = find_jumps(schema_.controls[c], samples, least_jump * limits.tolerance);
      if (!jumps.empty()) curves_[c] = fit_jumping_curve(schema_.controls[c], samples, jumps, limits);
      if (curves_[c].part.shapes.empty()) curves_[c] = fit_curve(schema_.controls[c], samples, limits);
      analysis_.curve_error = std::max(analysis_.curve_error, curves_[c].error / diagonal_);
      progress_.step(i + 1);
    }
    if (controls.size() < rest_.size())
      progress_.note(format("%zu of %zu controls were never recorded alone: their curves are estimates",
                            rest_.size() - controls.size(), rest_.size()));
  }

  CurveSamples read_alone(std::uint32_t c) const {
    const Control& control = schema_.controls[c];
    CurveSamples samples;
    samples.control = c;
    for (const bool up : {false, true}) {
      const double reach = double(up ? control.maximum : control.minimum) - control.rest;
      std::map<double, std::size_t> at;  // position: pose
      for (const std::size_t i : alone_[2 * c + up]) {
        const double share = (double(pose(i)[c]) - control.rest) / reach;
        at.emplace(up ? share : -share, i);
      }
      const std::vector<std::pair<double, std::size_t>> all(at.begin(), at.end());
      const std::size_t count = std::min(most_alone, all.size());
      std::set<std::size_t> picked;
      for (std::size_t k = 0; k < count; ++k)
        picked.insert(count == 1 ? all.size() - 1 : k * (all.size() - 1) / (count - 1));
      for (std::size_t k = 0; k + 1 < all.size() && picked.size() < 4 * most_alone; ++k)
        if (touch(control, all[k].first, all[k + 1].first)) picked.insert({k, k + 1});  // both sides of a jump
      for (const std::size_t k : picked) {
        samples.positions.push_back(all[k].first);
        poses_.read_displacements(all[k].second, 1, samples.displacements.emplace_back(size_));
      }
    }
    return samples;
  }

  void append_curves(SparseBlendshapes& base) const {
    std::vector<const SparseBlendshapes*> parts;
    for (const ControlCurve& curve : curves_) parts.push_back(&curve.part);
    append(base, parts);
  }

  RecordedPoses recorded(std::span<const std::size_t> picked, const SparseBlendshapes& base) const {
    return {&poses_, controls_, rest_, picked, &base};
  }

  HoldoutSet holdout_set(const SparseBlendshapes& base) const {
    std::vector<float> controls, residuals(validation_.size() * size_);
    for (const std::size_t i : validation_) controls.insert(controls.end(), pose(i).begin(), pose(i).end());
    if (!validation_.empty()) recorded(validation_, base).read(0, validation_.size(), residuals, parallel_);
    return HoldoutSet(std::move(controls), std::move(residuals), rest_, parallel_);
  }

  // Features to fit by regression and the ridge of each.
  struct Carriers {
    std::vector<Feature> features;
    std::vector<std::uint32_t> indices;
    std::vector<double> ridge;
  };

  // A ramp for every side of a control that was not recorded alone, and a tent at its middle where enough poses show
  // it.
  Carriers side_carriers() const {
    Carriers carriers;
    const auto add = [&](const Feature& feature, double ridge) {
      carriers.indices.push_back(add_feature(carriers.features, feature));
      carriers.ridge.push_back(ridge);
    };
    for (std::uint32_t c = 0; c < rest_.size(); ++c)
      for (const bool up : {true, false}) {
        const auto active = static_cast<std::size_t>(std::count_if(fitted_.begin(), fitted_.end(), [&](std::size_t i) {
          return up ? pose(i)[c] > rest_[c] : pose(i)[c] < rest_[c];
        }));
        // A single pose at the end shows nothing of the positions between.
        const std::vector<std::size_t>& alone = alone_[2 * c + up];
        if (active == 0 || alone.size() > 1) continue;
        const double end = up ? 1 : -1;
        if (!alone.empty() && pose(alone[0])[c] != value_at(schema_.controls[c], end)) continue;
        if (alone.empty()) add(side_ramp(schema_.controls[c], c, up), ramp_ridge);
        if (active >= poses_per_tent) add(tent(schema_.controls[c], c, 0, end / 2, end), tent_ridge);
      }
    return carriers;
  }

  // Fits the sides of controls that were not recorded alone to the residuals of all fitted poses. Shapes that do not
  // lower the validation error are removed, tents before ramps.
  void fit_together() {
    if (fitted_.empty()) return;
    SparseBlendshapes known;
    append_curves(known);
    const Carriers carriers = side_carriers();
    std::vector<SparseBlendshapes> parts = best_parts(
        known, carriers.features,
        Regression(recorded(fitted_, known), carriers.features, carriers.indices, carriers.ridge, parallel_, progress_),
        options_.curve_tolerance);
    std::stable_partition(parts.begin(), parts.end(),
                          [](const SparseBlendshapes& part) { return part.features[0].kind == Feature::Kind::hat; });
    keep_helpful(known, parts);
    for (const SparseBlendshapes& part : parts) {
      ControlCurve& curve = curves_[part.features[0].control];
      const SparseBlendshapes* whole[] = {&part};
      append(curve.part, whole);
    }
  }

  // A part for every shape that moves some vertex further than `least`, over D.
  std::vector<SparseBlendshapes> parts_of(std::span<const Feature> features, std::vector<SparseShape> shapes,
                                          double least) const {
    std::vector<SparseBlendshapes> parts;
    for (SparseShape& shape : shapes) {
      double largest = 0;
      for (std::size_t i = 0; i < shape.offsets.size(); i += 3)
        largest = std::max(largest, std::hypot(double(shape.offsets[i]), shape.offsets[i + 1], shape.offsets[i + 2]));
      if (largest <= least * diagonal_) continue;
      SparseBlendshapes& part = parts.emplace_back();
      shape.feature = import_feature(part.features, features, shape.feature);
      part.shapes.push_back(std::move(shape));
    }
    return parts;
  }

  // The shapes of the strength of regularisation with the least validation error; strengths rise until it rises too.
  std::vector<SparseBlendshapes> best_parts(const SparseBlendshapes& known, std::span<const Feature> features,
                                            const Regression& regression, double least) const {
    std::vector<SparseBlendshapes> best;
    double best_error = HUGE_VAL;
    const HoldoutSet without = holdout_set(known);
    for (double strength = 1; strength <= strongest; strength *= strength_step) {
      std::vector<SparseBlendshapes> parts = parts_of(features, regression.shapes(strength, parallel_), least);
      HoldoutSet holdout = without;
      for (const SparseBlendshapes& part : parts) holdout.add(part, 1);
      const double error = holdout.error().rms;
      if (!(error < best_error)) break;
      best_error = error;
      best = std::move(parts);
    }
    return best;
  }

  // Leaves the parts that lower the validation error; returns by what factor they all together do.
  double keep_helpful(const SparseBlendshapes& known, std::vector<SparseBlendshapes>& parts) const {
    HoldoutSet holdout = holdout_set(known);
    const double before = holdout.error().rms;
    std::vector<const SparseBlendshapes*> pointers;
    for (const SparseBlendshapes& part : parts) {
      holdout.add(part, 1);
      pointers.push_back(&part);
    }
    const std::vector<bool> kept = holdout.prune(pointers);
    std::vector<SparseBlendshapes> helpful;
    for (std::size_t p = 0; p < parts.size(); ++p)
      if (kept[p]) helpful.push_back(std::move(parts[p]));
    parts = std::move(helpful);
    const HoldoutSet::Error error = holdout.error();
    if (!validation_.empty() && !pointers.empty())
      progress_.note(
          format("%zu of %zu shapes fitted to recorded poses lower the validation error; on %zu validation poses it is "
                 "%.2e of the diagonal (rms), %.4f (maximum)",
                 parts.size(), pointers.size(), validation_.size(), error.rms / diagonal_, error.max / diagonal_));
    return before > 0 ? error.rms / before : 1;
  }

  // The feature a control enters pairs as.
  Feature factor(std::uint32_t c) const {
    const Control& control = schema_.controls[c];
    if (has_side(control, true) && has_side(control, false)) return across(control, c);
    return side_ramp(control, c, has_side(control, true));
  }

  // Fits the products of correlated pairs together and keeps those that help, or none if they help little.
  void fit_pairs() {
    const std::size_t most = std::min<std::size_t>(options_.max_pairs, fitted_.size() / poses_per_corrective);
    if (most == 0) return;
    SparseBlendshapes known;
    append_curves(known);
    std::vector<Feature> features;
    for (std::uint32_t c = 0; c < rest_.size(); ++c) features.push_back(factor(c));
    const std::vector<ControlPair> chosen =
        correlated_pairs(recorded(fitted_, known), features, most, options_.seed, parallel_, progress_);
    std::vector<std::uint32_t> carriers;
    for (const auto& [a, b] : chosen)
      carriers.push_back(add_feature(features, {Feature::Kind::product, 0, 1, 0, 0, a, b}));
    const std::vector<double> ridge(carriers.size(), pair_ridge);
    pairs_ = best_parts(known, features,
                        Regression(recorded(fitted_, known), features, carriers, ridge, parallel_, progress_),
                        options_.corrective_tolerance);
    std::reverse(pairs_.begin(), pairs_.end());  // the weakest are tried first
    if (keep_helpful(known, pairs_) > worthwhile_pairs) pairs_.clear();
  }

  void assemble() {
    for (const ControlCurve& curve : curves_) analysis_.linear_controls += curve.part.shapes.size() == 1;
    append_curves(analysis_.base);
    for (const SparseBlendshapes& part : pairs_) {
      const Feature& product = part.features[part.shapes[0].feature];
      Corrective corrective;
      corrective.controls = {part.features[product.first].control, part.features[product.second].control};
      std::sort(corrective.controls.begin(), corrective.controls.end());
      for (const float offset : part.shapes[0].offsets) corrective.energy += double(offset) * offset;
      corrective.energy /= diagonal_ * diagonal_;
      const SparseBlendshapes* whole[] = {&part};
      corrective.features = append(analysis_.base, whole)[0];
      analysis_.correctives.push_back(std::move(corrective));
    }
    std::stable_sort(analysis_.correctives.begin(), analysis_.correctives.end(),
                     [](const Corrective& a, const Corrective& b) { return a.energy > b.energy; });
  }

  const PoseSet& poses_;
  const RigSchema& schema_;
  const AnalysisOptions& options_;
  const Parallel& parallel_;
  Progress& progress_;
  std::vector<float> controls_, rest_;
  std::size_t size_;
  double diagonal_;
  std::vector<ControlCurve> curves_;
  std::vector<std::vector<std::size_t>> alone_;   // poses of control c alone, at 2 c below rest and at 2 c + 1 above
  std::vector<std::size_t> fitted_, validation_;  // poses
  std::vector<SparseBlendshapes> pairs_;
  RigAnalysis analysis_;
};

}  // namespace

RigAnalysis analyse_poses(const PoseSet& poses, const AnalysisOptions& options, const Parallel& parallel,
                          Progress& progress) {
  return RecordedAnalysis(poses, options, parallel, progress).run();
}

}  // namespace fb::bake
