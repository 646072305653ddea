#include "bake/analysis/live/compose_joints.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>

#include "bake/analysis/activation_curve.h"
#include "bake/analysis/live/joint_moves.h"
#include "bake/analysis/live/joint_order.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr int curve_samples = 4;  // of a side of a control
constexpr std::size_t most_pairs_asked = 10000;
constexpr double enough_left = 0.1;  // of the tolerance: what is left within rotations

double length(const Axis& v) {
  return std::sqrt(dot(v, v));
}

// Of two rotations that are nearly the same.
double distance(const Axis& a, const Axis& b) {
  return length(turned_before(a, b));
}

Axis plus(const Axis& a, const Axis& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Axis minus(const Axis& a, const Axis& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

// The sine of the angle between two vectors, times both.
double cross_length(const Axis& a, const Axis& b) {
  return length({a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]});
}

// Sides of controls, -1 or 1, as poses of one control.
std::vector<std::vector<ControlPlace>> control_ends(const RigSchema& schema) {
  std::vector<std::vector<ControlPlace>> ends;
  for (std::uint32_t c = 0; c < schema.control_count(); ++c)
    for (const bool up : {false, true})
      if (has_side(schema.controls[c], up)) ends.push_back({{c, up ? 1.0 : -1.0}});
  return ends;
}

// What each of some controls does to joints, at the positions where it was evaluated; nothing at rest.
using Samples = std::map<std::uint32_t, std::map<double, JointMoves>>;

class OrderSearch {
 public:
  OrderSearch(RigEvaluator& rig, double tolerance, Progress& progress)
      : rig_(rig), driven_(rig.rest().driven), progress_(progress), tolerance_(tolerance) {
    reaches_ = joint_reaches(driven_, joint_rotation);
    // One that turns about one axis has no order.
    for (std::size_t j = 0; j < reaches_.size(); ++j)
      if (std::popcount(driven_.joints[j].numbers & joint_rotation) < 2) reaches_[j] = 0;
  }

  void run(std::vector<JointComposition>& compositions) {
    find_ends();
    ask_pairs();
    std::vector<std::vector<std::vector<std::uint32_t>>> found(driven_.joints.size());
    std::set<std::uint32_t> controls;
    for (std::size_t j = 0; j < pairs_.size(); ++j) {
      if (pairs_[j].empty()) continue;
      const double enough = enough_left * tolerance_;
      found[j] = JointOrder(pairs_[j]).rotations(enough * enough, most_outer_rotations + 1);
      found[j].erase(found[j].begin());  // the first has all that is left
      for (const auto& rotation : found[j]) controls.insert(rotation.begin(), rotation.end());
    }
    sample(controls);
    for (std::size_t j = 0; j < found.size(); ++j)
      for (const auto& rotation : found[j]) {
        VectorSum& sum = compositions[j].outer_rotations.emplace_back();
        for (const std::uint32_t c : rotation) sum.push_back(curve_of(c, j));
      }
  }

 private:
  // The end of each control at which it turns joints further.
  void find_ends() {
    const auto poses = control_ends(rig_.schema());
    const std::vector<JointMoves> moves = evaluate_joints(rig_, poses, "turning joints", progress_);
    ends_.resize(rig_.schema().control_count());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const auto [control, position] = poses[i][0];
      double size = 0;
      for (std::size_t j = 0; j < reaches_.size(); ++j) size += reaches_[j] * length(moves[i][j].turn);
      if (size > ends_[control].size) ends_[control] = {position, size, moves[i]};
    }
  }

  // How much the order of two controls matters to a joint.
  double order_of(std::uint32_t a, std::uint32_t b, std::size_t joint) const {
    return reaches_[joint] * cross_length(ends_[a].moves[joint].turn, ends_[b].moves[joint].turn) / 2;
  }

  // Evaluates pairs of controls that turn a joint about different axes, those whose order matters most first.
  void ask_pairs() {
    struct Pair {
      std::uint32_t a, b;
      double size;
    };
    std::vector<Pair> pairs;
    for (std::uint32_t b = 0; b < ends_.size(); ++b)
      for (std::uint32_t a = 0; a < b; ++a) {
        double size = 0;
        for (std::size_t j = 0; ends_[a].size > 0 && ends_[b].size > 0 && j < reaches_.size(); ++j)
          size = std::max(size, order_of(a, b, j));
        if (size > tolerance_) pairs.push_back({a, b, size});
      }
    std::ranges::stable_sort(pairs, std::greater(), &Pair::size);
    if (pairs.size() > most_pairs_asked) pairs.resize(most_pairs_asked);
    std::vector<std::vector<ControlPlace>> poses;
    for (const Pair& pair : pairs)
      poses.push_back({{pair.a, ends_[pair.a].position}, {pair.b, ends_[pair.b].position}});
    const std::vector<JointMoves> moves = evaluate_joints(rig_, poses, "turning joints by pairs", progress_);
    pairs_.resize(reaches_.size());
    for (std::size_t i = 0; i < pairs.size(); ++i)
      for (std::size_t j = 0; j < reaches_.size(); ++j)
        if (order_of(pairs[i].a, pairs[i].b, j) > tolerance_ / 4) {
          const Axis &a = ends_[pairs[i].a].moves[j].turn, &b = ends_[pairs[i].b].moves[j].turn;
          const auto left = [&](const Axis& guess) {
            const double off = reaches_[j] * distance(moves[i][j].turn, guess);
            return off * off;
          };
          pairs_[j].push_back(
              {pairs[i].a, pairs[i].b, left(plus(a, b)), left(turned_further(a, b)), left(turned_further(b, a))});
        }
  }

  void sample(const std::set<std::uint32_t>& controls) {
    std::vector<std::vector<ControlPlace>> poses;
    for (const std::uint32_t c : controls)
      for (const int side : {-1, 1})
        for (int k = 1; k <= curve_samples && has_side(rig_.schema().controls[c], side > 0); ++k)
          poses.push_back({{c, double(side) * k / curve_samples}});
    const std::vector<JointMoves> moves = evaluate_joints(rig_, poses, "turning joints", progress_);
    for (const std::uint32_t c : controls) samples_[c][0] = JointMoves(reaches_.size());
    for (std::size_t i = 0; i < poses.size(); ++i) samples_[poses[i][0].first][poses[i][0].second] = moves[i];
  }

  VectorCurve curve_of(std::uint32_t c, std::size_t joint) const {
    VectorCurve curve{c, {}, {}};
    for (const auto& [position, moves] : samples_.at(c)) {
      curve.values.push_back(value_at(rig_.schema().controls[c], position));
      curve.vectors.push_back(moves[joint].turn);
    }
    return curve;
  }

  struct End {
    double position = 0, size = 0;  // size: how far its turns move vertices
    JointMoves moves;
  };

  RigEvaluator& rig_;
  const DrivenJoints& driven_;
  Progress& progress_;
  const double tolerance_;
  std::vector<double> reaches_;                  // of rotations, by joint; 0 where order does not matter
  std::vector<End> ends_;                        // by control
  std::vector<std::vector<PairOfTurns>> pairs_;  // by joint
  Samples samples_;
};

class PivotSearch {
 public:
  PivotSearch(RigEvaluator& rig, double tolerance, Progress& progress)
      : rig_(rig),
        driven_(rig.rest().driven),
        progress_(progress),
        tolerance_(tolerance),
        reaches_(joint_reaches(driven_, joint_translation)) {
    constexpr std::uint32_t wanted = joint_rotation | joint_translation;
    for (std::size_t j = 0; j < reaches_.size(); ++j)
      if ((driven_.joints[j].numbers & wanted) != wanted) reaches_[j] = 0;
  }

  void run(std::vector<JointComposition>& compositions) {
    if (std::ranges::all_of(reaches_, [](double reach) { return reach == 0; })) return;
    find_bases();
    std::vector<Found> found = pivots_at(control_ends(rig_.schema()));
    std::vector<std::vector<ControlPlace>> halves;
    for (const Found& one : found)
      if (std::vector<ControlPlace> half = {{one.place.first, one.place.second / 2}};
          halves.empty() || halves.back() != half)
        halves.push_back(std::move(half));
    const std::vector<Found> found_halfway = pivots_at(halves);
    found.insert(found.end(), found_halfway.begin(), found_halfway.end());
    std::map<std::pair<std::size_t, std::uint32_t>, std::map<double, Axis>> curves;  // of a joint and a control
    for (const Found& one : found) curves[{one.joint, one.place.first}][one.place.second] = one.pivot;
    for (auto& [of, pivots] : curves) {
      const auto [joint, control] = of;
      pivots[0] = {};
      VectorCurve& curve = compositions[joint].pivot.emplace_back(VectorCurve{control, {}, {}});
      for (const auto& [position, pivot] : pivots) {
        curve.values.push_back(value_at(rig_.schema().controls[control], position));
        curve.vectors.push_back(pivot);
      }
    }
  }

 private:
  static constexpr std::uint32_t bases = 4;
  static constexpr double base_position = 0.5, most_left = 0.1;

  // A control at a position moves the pivot of a joint.
  struct Found {
    std::size_t joint;
    ControlPlace place;
    Axis pivot;
  };

  // In each of a few poses, a part of the controls turns the joints.
  void find_bases() {
    std::vector<std::vector<ControlPlace>> poses(bases);
    for (std::uint32_t c = 0; c < rig_.schema().control_count(); ++c)
      poses[c % bases].push_back({c, has_side(rig_.schema().controls[c], true) ? base_position : -base_position});
    base_poses_ = poses;
    base_moves_ = evaluate_joints(rig_, poses, "turning joints", progress_);
  }

  // With each control added to all bases that it is no part of.
  std::vector<Found> pivots_at(const std::vector<std::vector<ControlPlace>>& places) {
    std::vector<std::vector<ControlPlace>> poses = places;  // alone, too
    std::vector<std::uint32_t> base_of(places.size());
    for (std::uint32_t b = 0; b < bases; ++b)
      for (const std::vector<ControlPlace>& place : places)
        if (place[0].first % bases != b) {
          poses.push_back(base_poses_[b]);
          poses.back().push_back(place[0]);
          base_of.push_back(b);
        }
    const std::vector<JointMoves> moves = evaluate_joints(rig_, poses, "turning joints about pivots", progress_);
    std::map<ControlPlace, std::vector<std::size_t>> with;  // poses
    for (std::size_t i = places.size(); i < poses.size(); ++i) with[poses[i].back()].push_back(i);
    std::vector<Found> found;
    for (std::size_t i = 0; i < places.size(); ++i)
      for (std::size_t j = 0; j < reaches_.size(); ++j) {
        if (reaches_[j] == 0) continue;
        PivotFit fit(moves[i][j]);
        for (const std::size_t pose : with[places[i][0]]) fit.add(base_moves_[base_of[pose]][j], moves[pose][j]);
        const auto [pivot, moved, left] = fit.solve();
        if (reaches_[j] * moved > tolerance_ && left < most_left * moved) found.push_back({j, places[i][0], pivot});
      }
    return found;
  }

  // The pivot of a control by least squares. Beside what it moves the joint by alone, it moves it by p - R p in a pose
  // that turns it by R without it, if it does not turn the joint itself.
  class PivotFit {
   public:
    explicit PivotFit(const JointMove& alone) : alone_(alone) {}

    void add(const JointMove& base, const JointMove& with) {
      const Axis moved = minus(minus(with.move, base.move), alone_.move);
      const Frame<double> rotation = rotation_about(with.turn);
      for (std::size_t row = 0; row < 3; ++row) {
        Axis equation;
        for (std::size_t k = 0; k < 3; ++k) equation[k] = (row == k) - rotation[4 * row + k];
        for (std::size_t a = 0; a < 3; ++a) {
          for (std::size_t b = 0; b < 3; ++b) normal_[4 * a + b] += equation[a] * equation[b];
          normal_[4 * a + 3] += equation[a] * moved[row];
        }
        squares_ += moved[row] * moved[row];
      }
    }

    struct Solution {
      Axis pivot;
      double moved, left;  // roots of sums of squares over poses
    };
    Solution solve() const {
      Frame<double> matrix = normal_;
      for (const std::size_t diagonal : {0, 5, 10}) matrix[diagonal] += 1e-9;
      const Axis right = {normal_[3], normal_[7], normal_[11]};
      matrix[3] = matrix[7] = matrix[11] = 0;
      const auto back = inverse(matrix);
      if (!back) return {{}, std::sqrt(squares_), std::sqrt(squares_)};
      Axis pivot;
      for (std::size_t a = 0; a < 3; ++a)
        pivot[a] = dot({(*back)[4 * a], (*back)[4 * a + 1], (*back)[4 * a + 2]}, right);
      return {pivot, std::sqrt(squares_), std::sqrt(std::max(squares_ - dot(pivot, right), 0.0))};
    }

   private:
    const JointMove alone_;
    Frame<double> normal_ = {};  // and the right side
    double squares_ = 0;
  };

  RigEvaluator& rig_;
  const DrivenJoints& driven_;
  Progress& progress_;
  const double tolerance_;
  std::vector<double> reaches_;  // of translations, by joint; 0 where there is no pivot to look for
  std::vector<std::vector<ControlPlace>> base_poses_;
  std::vector<JointMoves> base_moves_;
};

}  // namespace

std::vector<JointComposition> compose_joints(RigEvaluator& rig, const AnalysisOptions& options, Progress& progress) {
  std::vector<JointComposition> compositions(rig.rest().driven.joints.size());
  const double tolerance = options.corrective_tolerance * rig.diagonal();
  OrderSearch(rig, tolerance, progress).run(compositions);
  PivotSearch(rig, tolerance, progress).run(compositions);
  std::size_t joints = 0, rotations = 0, pivots = 0;
  for (const JointComposition& composition : compositions) {
    joints += !composition.empty();
    rotations += composition.outer_rotations.size();
    pivots += !composition.pivot.empty();
  }
  if (joints == 0) return {};
  progress.note(format("controls act on %zu driven joints one after the other: %zu outer rotations, %zu pivots", joints,
                       rotations, pivots));
  return compositions;
}

}  // namespace fb::bake
