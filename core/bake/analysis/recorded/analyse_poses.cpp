#include <algorithm>
#include <cmath>
#include <map>

#include "bake/analysis/activation_curve.h"
#include "bake/analysis/blendshape_parts.h"
#include "bake/analysis/holdout_set.h"
#include "bake/analysis/recorded/recorded_motion.h"
#include "bake/analysis/recorded/recorded_pairs.h"
#include "bake/analysis/recorded/regression.h"
#include "bake/analysis/rig_analysis.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t most_fitted = 6000;  // poses, evenly spaced
constexpr std::size_t most_held = 400;     // poses to judge by; at most a fifth of all
constexpr std::size_t most_alone = 24;     // poses of one control alone, a side
constexpr std::size_t poses_a_term = 20;   // fitted for every pair given a term
constexpr double straight_ridge = 1e-4, bent_ridge = 1e-3, pair_ridge = 1e-4;

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
    if (poses_.size() == 0) fail(Status::invalid_argument, "there are no poses to fit a base to");
    sort_poses();
    fit_alone();
    fit_together();
    fit_pairs();
    assemble();
    std::vector<const SparseBlendshapes*> parts;
    for (const ControlCurve& curve : curves_) parts.push_back(&curve.part);
    for (const SparseBlendshapes& part : pairs_) parts.push_back(&part);
    probe_.motion = motion_of(schema_, parts, size_ / 3, diagonal_, parallel_);
    probe_.residual_motion =
        missed_with(recorded(fitted_, probe_.base), probe_.motion, diagonal_, parallel_, progress_);
    return std::move(probe_);
  }

 private:
  std::span<const float> pose(std::size_t i) const {
    return std::span(controls_).subspan(i * rest_.size(), rest_.size());
  }

  // Which poses move one control alone; of the others, which are fitted and which are kept to judge by.
  void sort_poses() {
    std::vector<std::size_t> mixed;
    std::vector<std::size_t> moved(rest_.size());
    alone_.resize(2 * rest_.size());
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      std::size_t count = 0, last = 0;
      for (std::size_t c = 0; c < rest_.size(); ++c)
        if (pose(i)[c] != rest_[c]) ++count, last = c, ++moved[c];
      if (count == 1) alone_[2 * last + (pose(i)[last] > rest_[last])].push_back(i);
      if (count > 1) mixed.push_back(i);
    }
    // Held poses lie together in short runs, so that neighbours of the same motion are not on both sides.
    const std::size_t held = std::min(most_held, mixed.size() / 5), runs = (held + 7) / 8;
    std::vector<bool> is_held(mixed.size());
    for (std::size_t r = 0; r < runs; ++r)
      for (std::size_t i = 0; i < 8; ++i) is_held[std::min(mixed.size() - 1, r * mixed.size() / runs + i)] = true;
    std::vector<std::size_t> rest_of;
    for (std::size_t i = 0; i < mixed.size(); ++i) (is_held[i] ? held_ : rest_of).push_back(mixed[i]);
    const std::size_t fitted = std::min(most_fitted, rest_of.size());
    for (std::size_t i = 0; i < fitted; ++i) fitted_.push_back(rest_of[i * rest_of.size() / fitted]);
    std::size_t never = 0;
    std::string first;
    for (std::size_t c = 0; c < rest_.size(); ++c)
      if (moved[c] == 0 && never++ == 0) first = schema_.controls[c].name;
    if (never > 0)
      progress_.note(
          format("%zu of %zu controls never leave rest in the recorded poses (\"%s\"%s): they will move nothing", never,
                 rest_.size(), first.c_str(), never > 1 ? ", ..." : ""));
  }

  // Curves through what was recorded of one control alone.
  void fit_alone() {
    const CurveLimits limits{options_.curve_tolerance * diagonal_, 1e-6 * diagonal_, options_.max_knots};
    std::vector<std::uint32_t> controls;
    for (std::uint32_t c = 0; c < rest_.size(); ++c)
      if (!alone_[2 * c].empty() || !alone_[2 * c + 1].empty()) controls.push_back(c);
    progress_.begin("fitting controls recorded alone", controls.size());
    for (std::size_t i = 0; i < controls.size(); ++i) {
      const std::uint32_t c = controls[i];
      const CurveSamples samples = read_alone(c);
      curves_[c] = fit_curve(schema_.controls[c], samples, limits);
      probe_.curve_error = std::max(probe_.curve_error, curves_[c].error / diagonal_);
      progress_.step(i + 1);
    }
    if (controls.size() < rest_.size())
      progress_.note(format("%zu of %zu controls were never recorded alone: what they do is an estimate",
                            rest_.size() - controls.size(), rest_.size()));
  }

  CurveSamples read_alone(std::uint32_t c) const {
    const Control& control = schema_.controls[c];
    CurveSamples samples;
    samples.control = c;
    for (const bool up : {false, true}) {
      const double reach = double(up ? control.maximum : control.minimum) - control.rest;
      std::map<double, std::size_t> at;  // place: pose
      for (const std::size_t i : alone_[2 * c + up]) {
        const double share = (double(pose(i)[c]) - control.rest) / reach;
        at.emplace(up ? share : -share, i);
      }
      const std::vector<std::pair<double, std::size_t>> all(at.begin(), at.end());
      const std::size_t count = std::min(most_alone, all.size());
      for (std::size_t k = 0; k < count; ++k) {
        const auto& [place, i] = all[count == 1 ? all.size() - 1 : k * (all.size() - 1) / (count - 1)];
        samples.places.push_back(place);
        poses_.read_displacements(i, 1, samples.displacements.emplace_back(size_));
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

  HoldoutSet held_poses(const SparseBlendshapes& base) const {
    std::vector<float> controls, left(held_.size() * size_);
    for (const std::size_t i : held_) controls.insert(controls.end(), pose(i).begin(), pose(i).end());
    if (!held_.empty()) recorded(held_, base).read(0, held_.size(), left, parallel_);
    return HoldoutSet(std::move(controls), std::move(left), rest_, parallel_);
  }

  // Curves of the sides of controls that were not recorded alone: straight on each side, with a bend half way where
  // enough poses tell of it. What brings held poses no closer goes, bends before lines.
  void fit_together() {
    if (fitted_.empty()) return;
    SparseBlendshapes known;
    append_curves(known);
    std::vector<Feature> features;
    std::vector<std::uint32_t> carriers;
    std::vector<double> ridge;
    for (std::uint32_t c = 0; c < rest_.size(); ++c) {
      for (const bool up : {true, false}) {
        const std::size_t told = std::count_if(fitted_.begin(), fitted_.end(), [&](std::size_t i) {
          return up ? pose(i)[c] > rest_[c] : pose(i)[c] < rest_[c];
        });
        // A single pose at the end says nothing of the way there.
        const std::vector<std::size_t>& alone = alone_[2 * c + up];
        if (told == 0 || alone.size() > 1) continue;
        const double end = up ? 1 : -1;
        if (!alone.empty() && pose(alone[0])[c] != value_at(schema_.controls[c], end)) continue;
        if (alone.empty()) {
          carriers.push_back(add_feature(features, side_ramp(schema_.controls[c], c, up)));
          ridge.push_back(straight_ridge);
        }
        if (told < 20) continue;
        carriers.push_back(add_feature(features, tent(schema_.controls[c], c, 0, end / 2, end)));
        ridge.push_back(bent_ridge);
      }
    }
    std::vector<SparseBlendshapes> parts =
        parts_of(features, regress(recorded(fitted_, known), features, carriers, ridge, parallel_, progress_),
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

  // A part of its own for every shape that moves some vertex further than `least`, over D.
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

  // Leaves the parts that bring held poses closer to the recording.
  void keep_helpful(const SparseBlendshapes& known, std::vector<SparseBlendshapes>& parts) const {
    HoldoutSet held = held_poses(known);
    std::vector<const SparseBlendshapes*> pointers;
    for (const SparseBlendshapes& part : parts) {
      held.add(part, 1);
      pointers.push_back(&part);
    }
    const std::vector<bool> kept = held.judge(pointers);
    std::vector<SparseBlendshapes> helpful;
    for (std::size_t p = 0; p < parts.size(); ++p)
      if (kept[p]) helpful.push_back(std::move(parts[p]));
    parts = std::move(helpful);
    const HoldoutSet::Error error = held.error();
    if (!held_.empty() && !pointers.empty())
      progress_.note(
          format("%zu of %zu shapes fitted to recorded poses help; %zu poses kept back are off by %.2e (rms) "
                 "and %.4f (most) of the diagonal",
                 parts.size(), pointers.size(), held_.size(), error.rms / diagonal_, error.max / diagonal_));
  }

  // What a control enters pairs as.
  Feature factor(std::uint32_t c) const {
    const Control& control = schema_.controls[c];
    if (has_side(control, true) && has_side(control, false)) return across(control, c);
    return side_ramp(control, c, has_side(control, true));
  }

  // Products of the pairs what is left goes along with most, fitted together; those kept that help.
  void fit_pairs() {
    const std::size_t most = std::min<std::size_t>(options_.max_pairs, fitted_.size() / poses_a_term);
    if (most == 0) return;
    SparseBlendshapes known;
    append_curves(known);
    std::vector<Feature> features;
    for (std::uint32_t c = 0; c < rest_.size(); ++c) features.push_back(factor(c));
    const std::vector<ControlPair> chosen =
        telling_pairs(recorded(fitted_, known), features, most, options_.seed, parallel_, progress_);
    std::vector<std::uint32_t> carriers;
    for (const auto& [a, b] : chosen)
      carriers.push_back(add_feature(features, {Feature::Kind::product, 0, 1, 0, 0, a, b}));
    const std::vector<double> ridge(carriers.size(), pair_ridge);
    pairs_ = parts_of(features, regress(recorded(fitted_, known), features, carriers, ridge, parallel_, progress_),
                      options_.corrective_tolerance);
    std::reverse(pairs_.begin(), pairs_.end());  // the last found are judged first
    keep_helpful(known, pairs_);
  }

  void assemble() {
    for (const ControlCurve& curve : curves_) probe_.linear_controls += curve.part.shapes.size() == 1;
    append_curves(probe_.base);
    for (const SparseBlendshapes& part : pairs_) {
      const Feature& product = part.features[part.shapes[0].feature];
      Corrective corrective;
      corrective.controls = {part.features[product.first].control, part.features[product.second].control};
      std::sort(corrective.controls.begin(), corrective.controls.end());
      for (const float offset : part.shapes[0].offsets) corrective.energy += double(offset) * offset;
      corrective.energy /= diagonal_ * diagonal_;
      const SparseBlendshapes* whole[] = {&part};
      corrective.features = append(probe_.base, whole)[0];
      probe_.correctives.push_back(std::move(corrective));
    }
    std::stable_sort(probe_.correctives.begin(), probe_.correctives.end(),
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
  std::vector<std::vector<std::size_t>> alone_;  // poses of control c alone, at 2 c below rest and at 2 c + 1 above
  std::vector<std::size_t> fitted_, held_;
  std::vector<SparseBlendshapes> pairs_;
  RigAnalysis probe_;
};

}  // namespace

RigAnalysis analyse_poses(const PoseSet& poses, const AnalysisOptions& options, const Parallel& parallel,
                          Progress& progress) {
  return RecordedAnalysis(poses, options, parallel, progress).run();
}

}  // namespace fb::bake
