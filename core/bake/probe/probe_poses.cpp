#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "bake/linalg/gemm.h"
#include "bake/probe/base_parts.h"
#include "bake/probe/control_curve.h"
#include "bake/probe/held_poses.h"
#include "bake/probe/probe.h"
#include "bake/probe/regression.h"
#include "base/random.h"
#include "base/status.h"

namespace fb {
namespace {

constexpr std::size_t most_fitted = 6000;  // poses, evenly spaced
constexpr std::size_t most_held = 400;     // poses to judge by; at most a fifth of all
constexpr std::size_t most_alone = 24;     // poses of one control alone, a side
constexpr std::size_t poses_a_term = 20;   // fitted for every pair given a term
constexpr std::size_t sketch_width = 48;   // numbers a pose that stand for its residual when pairs are ranked
constexpr std::size_t pair_rounds = 4;
constexpr double straight_ridge = 1e-4, bent_ridge = 1e-3, pair_ridge = 1e-4;

// Numbers drawn so that products with them keep lengths, on average: a random projection (Johnson, Lindenstrauss 1984).
std::vector<float> draw_projection(std::size_t size, std::uint64_t seed) {
  std::vector<float> projection(size * sketch_width);
  for (std::size_t i = 0; i < size; ++i) {
    Random random(seed, std::uint64_t{11} << 48 | i);
    for (std::size_t k = 0; k < sketch_width; ++k) projection[k * size + i] = random.normal();
  }
  return projection;
}

class RecordedProbe {
 public:
  RecordedProbe(const PoseSet& poses, const ProbeOptions& options, const Parallel& parallel, Progress& progress)
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

  Probe run() {
    if (poses_.size() == 0) fail(Status::invalid_argument, "there are no poses to fit a base to");
    sort_poses();
    fit_alone();
    fit_together();
    fit_pairs();
    assemble();
    measure_motion();
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
    alone_.resize(rest_.size());
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      std::size_t count = 0, last = 0;
      for (std::size_t c = 0; c < rest_.size(); ++c)
        if (pose(i)[c] != rest_[c]) ++count, last = c, ++moved[c];
      if (count == 1) alone_[last].push_back(i);
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
      if (!alone_[c].empty()) controls.push_back(c);
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
    std::map<double, std::size_t> at[2];  // place: pose
    for (const std::size_t i : alone_[c]) {
      const float value = pose(i)[c];
      const bool up = value > control.rest;
      const double reach = double(up ? control.maximum : control.minimum) - control.rest;
      const double place = (double(value) - control.rest) / reach;
      at[up].emplace(up ? place : -place, i);
    }
    CurveSamples samples;
    samples.control = c;
    for (const bool up : {false, true}) {
      std::vector<std::pair<double, std::size_t>> all(at[up].begin(), at[up].end());
      const std::size_t count = std::min(most_alone, all.size());
      for (std::size_t k = 0; k < count; ++k) {
        const auto& [place, i] = all[count == 1 ? all.size() - 1 : k * (all.size() - 1) / (count - 1)];
        samples.places.push_back(place);
        poses_.read_displacements(i, 1, samples.displacements.emplace_back(size_));
      }
    }
    return samples;
  }

  void append_curves(CurveBase& base) const {
    std::vector<const CurveBase*> parts;
    for (const ControlCurve& curve : curves_) parts.push_back(&curve.part);
    append(base, parts);
  }

  RecordedPoses recorded(std::span<const std::size_t> picked, const CurveBase& base) const {
    return {&poses_, controls_, rest_, picked, &base};
  }

  HeldPoses held_poses(const CurveBase& base) const {
    std::vector<float> controls, left(held_.size() * size_);
    for (const std::size_t i : held_) controls.insert(controls.end(), pose(i).begin(), pose(i).end());
    if (!held_.empty()) recorded(held_, base).read(0, held_.size(), left, parallel_);
    return HeldPoses(std::move(controls), std::move(left), rest_, parallel_);
  }

  // Curves of the controls that were not recorded alone: straight on each side, with a bend half way where enough poses
  // tell of it. What brings held poses no closer goes, bends before lines.
  void fit_together() {
    if (fitted_.empty()) return;
    CurveBase known;
    append_curves(known);
    std::vector<Feature> features;
    std::vector<std::uint32_t> carriers;
    std::vector<double> ridge;
    for (std::uint32_t c = 0; c < rest_.size(); ++c) {
      if (!alone_[c].empty()) continue;
      for (const bool up : {true, false}) {
        const std::size_t told = std::count_if(fitted_.begin(), fitted_.end(), [&](std::size_t i) {
          return up ? pose(i)[c] > rest_[c] : pose(i)[c] < rest_[c];
        });
        if (told == 0) continue;
        const double end = up ? 1 : -1;
        carriers.push_back(add_feature(features, side_ramp(schema_.controls[c], c, up)));
        ridge.push_back(straight_ridge);
        if (told < 20) continue;
        carriers.push_back(add_feature(features, tent(schema_.controls[c], c, 0, end / 2, end)));
        ridge.push_back(bent_ridge);
      }
    }
    std::vector<CurveBase> parts =
        parts_of(features, regress(recorded(fitted_, known), features, carriers, ridge, parallel_, progress_),
                 options_.curve_tolerance);
    std::stable_partition(parts.begin(), parts.end(),
                          [](const CurveBase& part) { return part.features[0].kind == Feature::Kind::hat; });
    keep_helpful(known, parts);
    for (const CurveBase& part : parts) {
      ControlCurve& curve = curves_[part.features[0].control];
      const CurveBase* whole[] = {&part};
      append(curve.part, whole);
    }
  }

  // A part of its own for every shape that moves some vertex further than `least`, over D.
  std::vector<CurveBase> parts_of(std::span<const Feature> features, std::vector<SparseShape> shapes,
                                  double least) const {
    std::vector<CurveBase> parts;
    for (SparseShape& shape : shapes) {
      double largest = 0;
      for (std::size_t i = 0; i < shape.offsets.size(); i += 3)
        largest = std::max(largest, std::hypot(double(shape.offsets[i]), shape.offsets[i + 1], shape.offsets[i + 2]));
      if (largest <= least * diagonal_) continue;
      CurveBase& part = parts.emplace_back();
      shape.feature = import_feature(part.features, features, shape.feature);
      part.shapes.push_back(std::move(shape));
    }
    return parts;
  }

  // Leaves the parts that bring held poses closer to the recording.
  void keep_helpful(const CurveBase& known, std::vector<CurveBase>& parts) const {
    HeldPoses held = held_poses(known);
    std::vector<const CurveBase*> pointers;
    for (const CurveBase& part : parts) {
      held.add(part, 1);
      pointers.push_back(&part);
    }
    const std::vector<bool> kept = held.judge(pointers);
    std::vector<CurveBase> helpful;
    for (std::size_t p = 0; p < parts.size(); ++p)
      if (kept[p]) helpful.push_back(std::move(parts[p]));
    parts = std::move(helpful);
    const HeldPoses::Error error = held.error();
    if (!held_.empty())
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

  // Products of two controls that what is left goes along with most, a few at a time, each time less what those before
  // take; then all fitted together, and those kept that help.
  void fit_pairs() {
    const std::size_t most = std::min<std::size_t>(options_.max_pairs, fitted_.size() / poses_a_term);
    if (most == 0) return;
    CurveBase known;
    append_curves(known);
    const std::size_t count = fitted_.size(), width = rest_.size();
    const auto n = static_cast<Eigen::Index>(count);
    // What is left of each pose, as a few numbers: count x sketch_width.
    Eigen::MatrixXf sketch(n, static_cast<Eigen::Index>(sketch_width));
    const std::vector<float> projection = draw_projection(size_, options_.seed);
    std::vector<float> left, flat;
    constexpr std::size_t block = 128;
    progress_.begin("looking for pairs in recorded poses", count);
    for (std::size_t first = 0; first < count; first += block) {
      const std::size_t poses = std::min(block, count - first);
      left.resize(poses * size_);
      flat.resize(poses * sketch_width);
      recorded(fitted_, known).read(first, poses, left, parallel_);
      gemm(Op::transposed, Op::plain, poses, sketch_width, size_, left.data(), size_, projection.data(), size_, 0,
           flat.data(), poses);
      sketch.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(poses)) =
          Eigen::Map<const Eigen::MatrixXf>(flat.data(), static_cast<Eigen::Index>(poses),
                                            static_cast<Eigen::Index>(sketch_width));
      progress_.step(first + poses);
    }
    std::vector<Feature> features;
    for (std::uint32_t c = 0; c < width; ++c) features.push_back(factor(c));
    Eigen::MatrixXf single(n, static_cast<Eigen::Index>(width));
    std::vector<float> values(width);
    for (std::size_t i = 0; i < count; ++i) {
      evaluate_features(features, pose(fitted_[i]), rest_, values);
      for (std::size_t c = 0; c < width; ++c)
        single(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) = values[c];
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> chosen;
    Eigen::MatrixXf unexplained = sketch, columns(n, 0);
    for (std::size_t round = 0; round < pair_rounds; ++round) {
      add_pairs(single, unexplained, (most + pair_rounds - 1) / pair_rounds, chosen, columns);
      if (chosen.empty()) return;
      // Columns have length 1; the small ridge keeps the fit from leaning on near copies.
      const Eigen::MatrixXf gram =
          columns.transpose() * columns + 1e-3f * Eigen::MatrixXf::Identity(columns.cols(), columns.cols());
      unexplained = sketch - columns * gram.ldlt().solve(columns.transpose() * sketch);
    }
    std::vector<std::uint32_t> carriers;
    for (const auto& [a, b] : chosen)
      carriers.push_back(add_feature(features, {Feature::Kind::product, 0, 1, 0, 0, a, b}));
    const std::vector<double> ridge(carriers.size(), pair_ridge);
    pairs_ = parts_of(features, regress(recorded(fitted_, known), features, carriers, ridge, parallel_, progress_),
                      options_.term_tolerance);
    std::reverse(pairs_.begin(), pairs_.end());  // the last found are judged first
    keep_helpful(known, pairs_);
  }

  // Adds the pairs whose product explains most of the sketch.
  void add_pairs(const Eigen::MatrixXf& single, const Eigen::MatrixXf& sketch, std::size_t wanted,
                 std::vector<std::pair<std::uint32_t, std::uint32_t>>& chosen, Eigen::MatrixXf& columns) const {
    const auto width = static_cast<std::uint32_t>(rest_.size());
    struct Gain {
      float share;
      std::uint32_t a, b;
    };
    std::vector<std::vector<Gain>> of_control(width);
    const float energy = sketch.squaredNorm();
    parallel_for(parallel_, width, [&](std::size_t a, std::size_t) {
      const auto first = static_cast<Eigen::Index>(a);
      const Eigen::Index others = static_cast<Eigen::Index>(width) - first - 1;
      if (others == 0 || energy == 0) return;
      const Eigen::MatrixXf products = single.rightCols(others).array().colwise() * single.col(first).array();
      const Eigen::MatrixXf along = products.transpose() * sketch;
      for (Eigen::Index k = 0; k < others; ++k) {
        const float length = products.col(k).squaredNorm();
        if ((products.col(k).array() != 0).count() < 8) continue;  // too few poses tell of it
        of_control[a].push_back({along.row(k).squaredNorm() / length / energy, static_cast<std::uint32_t>(a),
                                 static_cast<std::uint32_t>(first + 1 + k)});
      }
    });
    std::vector<Gain> gains;
    for (const std::vector<Gain>& some : of_control) gains.insert(gains.end(), some.begin(), some.end());
    std::stable_sort(gains.begin(), gains.end(), [](const Gain& a, const Gain& b) { return a.share > b.share; });
    // A product that has nothing to do with what is left explains one of as many directions as there are poses.
    const float chance = 4 / static_cast<float>(sketch.rows());
    for (const Gain& gain : gains) {
      if (wanted == 0 || gain.share < chance) break;
      const std::pair pair(gain.a, gain.b);
      if (std::find(chosen.begin(), chosen.end(), pair) != chosen.end()) continue;
      chosen.push_back(pair);
      columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
      columns.rightCols(1) = single.col(gain.a).cwiseProduct(single.col(gain.b)).normalized();
      --wanted;
    }
  }

  void assemble() {
    for (const ControlCurve& curve : curves_) probe_.linear_controls += curve.part.shapes.size() == 1;
    append_curves(probe_.base);
    for (const CurveBase& part : pairs_) {
      const Feature& product = part.features[part.shapes[0].feature];
      Interaction interaction;
      interaction.controls = {part.features[product.first].control, part.features[product.second].control};
      std::sort(interaction.controls.begin(), interaction.controls.end());
      for (const float offset : part.shapes[0].offsets) interaction.energy += double(offset) * offset;
      interaction.energy /= diagonal_ * diagonal_;
      const CurveBase* whole[] = {&part};
      interaction.features = append(probe_.base, whole)[0];
      probe_.interactions.push_back(std::move(interaction));
    }
    std::stable_sort(probe_.interactions.begin(), probe_.interactions.end(),
                     [](const Interaction& a, const Interaction& b) { return a.energy > b.energy; });
  }

  // What the base moves with each control at the ends of its range, and what pairs move where both are 1; and by how
  // much more the poses are missed, vertex by vertex, while a control that moves the vertex is on.
  void measure_motion() {
    const std::size_t width = rest_.size(), vertices = size_ / 3;
    probe_.motion.assign(width * vertices, 0);
    parallel_for(parallel_, width, [&](std::size_t c, std::size_t) {
      const Control& control = schema_.controls[c];
      std::vector<float> moved(size_), controls(rest_), values(probe_.base.features.size());
      const auto raise = [&] {
        for (std::size_t v = 0; v < vertices; ++v)
          probe_.motion[c * vertices + v] =
              std::max(probe_.motion[c * vertices + v],
                       static_cast<float>(std::hypot(moved[3 * v], moved[3 * v + 1], moved[3 * v + 2]) / diagonal_));
      };
      for (const double place : {-1.0, -0.5, 0.5, 1.0}) {
        if (!has_side(control, place > 0)) continue;
        controls[c] = value_at(control, place);
        std::fill(moved.begin(), moved.end(), 0.0f);
        curves_[c].part.add(controls, rest_, 1, 1, moved);
        raise();
      }
      for (const CurveBase& part : pairs_) {
        const bool mine = std::any_of(part.features.begin(), part.features.end(), [&](const Feature& f) {
          return f.kind != Feature::Kind::product && f.control == c;
        });
        if (!mine) continue;
        std::fill(moved.begin(), moved.end(), 0.0f);
        add_scaled(part.shapes[0], 1, moved);
        raise();
      }
    });
    measure_residual();
  }

  void measure_residual() {
    const std::size_t width = rest_.size(), vertices = size_ / 3, count = fitted_.size();
    probe_.residual_motion.assign(width * vertices, 0);
    if (count == 0) return;
    constexpr std::size_t block = 64;
    std::vector<float> left, squares;
    std::vector<double> all(vertices), fourth(vertices);
    std::vector<float> on(width * vertices);
    std::vector<std::size_t> on_count(width);
    progress_.begin("measuring what is left of recorded poses", count);
    for (std::size_t first = 0; first < count; first += block) {
      const std::size_t poses = std::min(block, count - first);
      left.resize(poses * size_);
      squares.resize(poses * vertices);
      recorded(fitted_, probe_.base).read(first, poses, left, parallel_);
      parallel_for(parallel_, poses, [&](std::size_t i, std::size_t) {
        for (std::size_t v = 0; v < vertices; ++v) {
          const float* d = left.data() + i * size_ + 3 * v;
          squares[i * vertices + v] = static_cast<float>(
              (double(d[0]) * d[0] + double(d[1]) * d[1] + double(d[2]) * d[2]) / (diagonal_ * diagonal_));
        }
      });
      for (std::size_t i = 0; i < poses; ++i)
        for (std::size_t v = 0; v < vertices; ++v) {
          const double s = squares[i * vertices + v];
          all[v] += s;
          fourth[v] += s * s;
        }
      parallel_for(parallel_, width, [&](std::size_t c, std::size_t) {
        for (std::size_t i = 0; i < poses; ++i) {
          if (pose(fitted_[first + i])[c] == rest_[c]) continue;
          ++on_count[c];
          for (std::size_t v = 0; v < vertices; ++v) on[c * vertices + v] += squares[i * vertices + v];
        }
      });
      progress_.step(first + poses);
    }
    parallel_for(parallel_, width, [&](std::size_t c, std::size_t) {
      const auto with = static_cast<double>(on_count[c]), without = static_cast<double>(count) - with;
      if (with == 0) return;
      for (std::size_t v = 0; v < vertices; ++v) {
        if (probe_.motion[c * vertices + v] <= 1e-5f) continue;
        const double mean_on = on[c * vertices + v] / with;
        const double mean_off = without > 0 ? std::max(0.0, all[v] - on[c * vertices + v]) / without : 0;
        const double mean = all[v] / double(count);
        const double variance = std::max(0.0, fourth[v] / double(count) - mean * mean);
        const double chance = without > 0 ? 2 * std::sqrt(variance * (1 / with + 1 / without)) : 0;
        if (mean_on - mean_off > chance)
          probe_.residual_motion[c * vertices + v] = static_cast<float>(std::sqrt(mean_on - mean_off));
      }
    });
  }

  const PoseSet& poses_;
  const RigSchema& schema_;
  const ProbeOptions& options_;
  const Parallel& parallel_;
  Progress& progress_;
  std::vector<float> controls_, rest_;
  std::size_t size_;
  double diagonal_;
  std::vector<ControlCurve> curves_;
  std::vector<std::vector<std::size_t>> alone_;  // poses of each control alone
  std::vector<std::size_t> fitted_, held_;
  std::vector<CurveBase> pairs_;
  Probe probe_;
};

}  // namespace

Probe probe_poses(const PoseSet& poses, const ProbeOptions& options, const Parallel& parallel, Progress& progress) {
  return RecordedProbe(poses, options, parallel, progress).run();
}

}  // namespace fb
