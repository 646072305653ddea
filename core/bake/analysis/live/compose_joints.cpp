#include "bake/analysis/live/compose_joints.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "bake/analysis/activation_curve.h"
#include "bake/analysis/live/joint_moves.h"
#include "bake/analysis/live/joint_order.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr int curve_samples = 4;  // of a side of a control
constexpr std::uint64_t most_pairs_asked = 10000, pairs_share = 8;  // of the rig budget
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

// What each control alone does to joints at the ends of its range.
struct AtEnds {
  std::vector<ControlPlace> places;
  std::vector<JointMoves> moves;
};

std::vector<std::vector<ControlPlace>> alone(std::span<const ControlPlace> places) {
  std::vector<std::vector<ControlPlace>> poses;
  for (const ControlPlace& place : places) poses.push_back({place});
  return poses;
}

AtEnds evaluate_ends(RigEvaluator& rig, Progress& progress) {
  AtEnds ends;
  for (std::uint32_t c = 0; c < rig.schema().control_count(); ++c)
    for (const bool up : {false, true})
      if (has_side(rig.schema().controls[c], up)) ends.places.emplace_back(c, up ? 1.0 : -1.0);
  ends.moves = evaluate_joints(rig, alone(ends.places), "turning joints", progress);
  return ends;
}

// vectors: at positions of the control; at rest it adds nothing.
VectorCurve curve_through(const RigSchema& schema, std::uint32_t control, std::map<double, Axis> vectors) {
  vectors[0] = {};
  VectorCurve curve{control, {}, {}};
  for (const auto& [position, vector] : vectors) {
    curve.values.push_back(value_at(schema.controls[control], position));
    curve.vectors.push_back(vector);
  }
  return curve;
}

class OrderSearch {
 public:
  // alone: what the controls do at the ends of their ranges.
  OrderSearch(RigEvaluator& rig, const AtEnds& alone, double tolerance, Progress& progress)
      : rig_(rig), driven_(rig.rest().driven), alone_(alone), progress_(progress), tolerance_(tolerance) {
    reaches_ = joint_reaches(driven_, joint_rotation);
    // One that turns about one axis has no order.
    for (std::size_t j = 0; j < reaches_.size(); ++j)
      if (std::popcount(driven_.joints[j].numbers & joint_rotation) < 2) reaches_[j] = 0;
    find_ends();
  }

  void run(std::vector<JointComposition>& compositions) {
    ask_pairs();
    std::vector<Order> orders(pairs_.size());
    std::set<std::uint32_t> controls;
    for (std::size_t j = 0; j < pairs_.size(); ++j) {
      if (pairs_[j].empty()) continue;
      orders[j] = order_of(j);
      for (std::size_t r = 1; r < orders[j].rotations.size(); ++r)
        controls.insert(orders[j].rotations[r].begin(), orders[j].rotations[r].end());
    }
    sample(controls);
    for (std::size_t j = 0; j < orders.size(); ++j)
      for (std::size_t r = 1; r < orders[j].rotations.size(); ++r) {
        VectorSum& sum = compositions[j].outer_rotations.emplace_back();
        for (const std::uint32_t c : orders[j].rotations[r]) sum.push_back(curve_of(c, j, orders[j].axes, r));
      }
  }

 private:
  // How two controls together turn a joint.
  struct JointPair {
    std::uint32_t joint, a, b;
    Axis turn;
  };

  // The controls of each rotation of a joint, from the inside out. With axes, rotation r is about axes[r] alone.
  struct Order {
    std::vector<std::vector<std::uint32_t>> rotations;
    std::optional<AxisOrder> axes;
  };

  // None where sums of vectors leave enough or least; Euler angles, which all controls add to, where those leave least
  // and an order of the controls is not as good with as few rotations.
  Order order_of(std::size_t joint) const {
    const double enough = enough_left * tolerance_ * enough_left * tolerance_;
    std::vector<PairOfTurns> pairs;
    double summed = 0;
    for (const JointPair& pair : pairs_[joint]) summed += pairs.emplace_back(turns_of(pair)).summed;
    if (summed <= enough) return {};
    const JointOrder order(pairs);
    Order best;
    double least = summed;
    if (const double left = std::max(order.left(), enough); left < least)
      least = left, best.rotations = order.rotations(enough, most_outer_rotations + 1);
    const bool few = best.rotations.size() > 1 && best.rotations.size() <= 3;
    for (const AxisOrder& axes : axis_orders) {
      double left = 0;
      for (const JointPair& pair : pairs_[joint]) left += left_by_angles(pair, axes);
      if (left < least && !(few && least <= enough)) least = left, best.axes = axes;
    }
    if (!best.axes) return best;
    std::vector<std::uint32_t> turning;
    for (std::uint32_t c = 0; c < ends_.size(); ++c)
      if (ends_[c].size > 0 && length(ends_[c].moves[joint].turn) > 0) turning.push_back(c);
    best.rotations.assign(3, turning);
    return best;
  }

  // The end of each control at which it turns joints further.
  void find_ends() {
    ends_.resize(rig_.schema().control_count());
    for (std::size_t i = 0; i < alone_.places.size(); ++i) {
      const auto [control, position] = alone_.places[i];
      double size = 0;
      for (std::size_t j = 0; j < reaches_.size(); ++j) size += reaches_[j] * length(alone_.moves[i][j].turn);
      if (size > ends_[control].size) ends_[control] = {position, size, alone_.moves[i]};
    }
  }

  // How much the order of two controls matters to a joint.
  double order_matters(std::uint32_t a, std::uint32_t b, std::size_t joint) const {
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
          size = std::max(size, order_matters(a, b, j));
        if (size > tolerance_) pairs.push_back({a, b, size});
      }
    std::ranges::stable_sort(pairs, std::greater(), &Pair::size);
    const auto most =
        static_cast<std::size_t>(std::min<std::uint64_t>(most_pairs_asked, rig_.remaining() / pairs_share));
    if (pairs.size() > most) pairs.resize(most);
    std::vector<std::vector<ControlPlace>> poses;
    for (const Pair& pair : pairs)
      poses.push_back({{pair.a, ends_[pair.a].position}, {pair.b, ends_[pair.b].position}});
    std::vector<std::vector<JointPair>> turned(pairs.size());
    visit_joints(rig_, poses, "turning joints by pairs", progress_, [&](std::size_t i, const JointMoves& moves) {
      for (std::uint32_t j = 0; j < reaches_.size(); ++j)
        if (order_matters(pairs[i].a, pairs[i].b, j) > tolerance_ / 4)
          turned[i].push_back({j, pairs[i].a, pairs[i].b, moves[j].turn});
    });
    pairs_.resize(reaches_.size());
    for (const std::vector<JointPair>& of_pair : turned)
      for (const JointPair& pair : of_pair) pairs_[pair.joint].push_back(pair);
  }

  // What is left of a rotation that was taken to be another, squared.
  double left(const JointPair& pair, const Axis& guess) const {
    const double off = reaches_[pair.joint] * distance(pair.turn, guess);
    return off * off;
  }

  PairOfTurns turns_of(const JointPair& pair) const {
    const Axis &a = ends_[pair.a].moves[pair.joint].turn, &b = ends_[pair.b].moves[pair.joint].turn;
    return {pair.a, pair.b, left(pair, plus(a, b)), left(pair, turned_further(a, b)), left(pair, turned_further(b, a))};
  }

  // For a pair that adds Euler angles.
  double left_by_angles(const JointPair& pair, const AxisOrder& axes) const {
    const auto angles = [&](std::uint32_t c) { return euler_angles(ends_[c].moves[pair.joint].turn, axes); };
    return left(pair, from_euler_angles(plus(angles(pair.a), angles(pair.b)), axes));
  }

  // What controls do to joints between the ends of their ranges, too.
  void sample(const std::set<std::uint32_t>& controls) {
    std::vector<std::vector<ControlPlace>> poses;
    for (std::size_t i = 0; i < alone_.places.size(); ++i) {
      const auto [control, end] = alone_.places[i];
      if (!controls.contains(control)) continue;
      samples_[control][end] = alone_.moves[i];
      for (int k = 1; k < curve_samples; ++k) poses.push_back({{control, end * k / curve_samples}});
    }
    const std::vector<JointMoves> moves = evaluate_joints(rig_, poses, "turning joints", progress_);
    for (std::size_t i = 0; i < poses.size(); ++i) samples_[poses[i][0].first][poses[i][0].second] = moves[i];
  }

  VectorCurve curve_of(std::uint32_t c, std::size_t joint, const std::optional<AxisOrder>& axes, std::size_t r) const {
    std::map<double, Axis> vectors;
    for (const auto& [position, moves] : samples_.at(c)) {
      const Axis& turn = moves[joint].turn;
      Axis& vector = vectors[position] = axes ? Axis{} : turn;
      if (axes) vector[(*axes)[r]] = euler_angles(turn, *axes)[(*axes)[r]];
    }
    return curve_through(rig_.schema(), c, std::move(vectors));
  }

  struct End {
    double position = 0, size = 0;  // size: how far its turns move vertices
    JointMoves moves;
  };

  RigEvaluator& rig_;
  const DrivenJoints& driven_;
  const AtEnds& alone_;
  Progress& progress_;
  const double tolerance_;
  std::vector<double> reaches_;                  // of rotations, by joint; 0 where order does not matter
  std::vector<End> ends_;                        // by control
  std::vector<std::vector<JointPair>> pairs_;    // by joint
  std::map<std::uint32_t, std::map<double, JointMoves>> samples_;  // by control and position
};

// The pivot of a control by least squares. Beside what it moves the joint by alone, it moves it by p - R p in a pose
// that turns it by R without it, if it does not turn the joint itself.
class PivotFit {
 public:
  PivotFit(const JointMove& alone) : alone_(alone) {}  // NOLINT: implicit

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

  double moved() const { return std::sqrt(squares_); }

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
    if (!back) return {{}, moved(), moved()};
    Axis pivot;
    for (std::size_t a = 0; a < 3; ++a) pivot[a] = dot({(*back)[4 * a], (*back)[4 * a + 1], (*back)[4 * a + 2]}, right);
    return {pivot, moved(), std::sqrt(std::max(squares_ - dot(pivot, right), 0.0))};
  }

 private:
  JointMove alone_;
  Frame<double> normal_ = {};  // and the right side
  double squares_ = 0;
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

  void run(const AtEnds& alone_at_ends, std::vector<JointComposition>& compositions) {
    if (std::ranges::all_of(reaches_, [](double reach) { return reach == 0; })) return;
    find_bases(alone_at_ends);
    std::vector<Found> found = pivots_at(alone_at_ends);
    AtEnds halfway;
    for (const Found& one : found)
      if (const ControlPlace half = {one.place.first, one.place.second / 2};
          halfway.places.empty() || halfway.places.back() != half)
        halfway.places.push_back(half);
    halfway.moves = evaluate_joints(rig_, alone(halfway.places), stage, progress_);
    const std::vector<Found> found_halfway = pivots_at(halfway);
    found.insert(found.end(), found_halfway.begin(), found_halfway.end());
    std::map<std::pair<std::size_t, std::uint32_t>, std::map<double, Axis>> curves;  // of a joint and a control
    for (const Found& one : found) curves[{one.joint, one.place.first}][one.place.second] = one.pivot;
    for (auto& [of, pivots] : curves)
      compositions[of.first].pivot.push_back(curve_through(rig_.schema(), of.second, std::move(pivots)));
  }

 private:
  static constexpr std::size_t bases = 3;
  static constexpr const char* stage = "turning joints about pivots";
  static constexpr double base_position = 0.7, most_left = 0.1;

  // A control at a position moves the pivot of a joint.
  struct Found {
    std::size_t joint;
    ControlPlace place;
    Axis pivot;
  };

  // Base k has of every joint the control that turns it the k-th furthest.
  void find_bases(const AtEnds& ends) {
    base_poses_.resize(bases);
    for (std::size_t j = 0; j < reaches_.size(); ++j) {
      if (reaches_[j] == 0) continue;
      std::vector<std::pair<double, ControlPlace>> furthest;
      for (std::size_t i = 0; i < ends.places.size(); ++i)
        if (const double angle = length(ends.moves[i][j].turn); angle > 0) furthest.push_back({-angle, ends.places[i]});
      std::ranges::sort(furthest);
      std::size_t base = 0;
      std::set<std::uint32_t> taken;
      for (const auto& [angle, place] : furthest) {
        if (base == bases) break;
        if (!taken.insert(place.first).second) continue;  // its other end
        std::vector<ControlPlace>& pose = base_poses_[base++];
        if (!has(pose, place.first)) pose.emplace_back(place.first, base_position * place.second);
      }
    }
    base_moves_ = evaluate_joints(rig_, base_poses_, stage, progress_);
  }

  static bool has(std::span<const ControlPlace> pose, std::uint32_t control) {
    return std::ranges::find(pose, control, &ControlPlace::first) != pose.end();
  }

  // With each control added to all bases that it is no part of; to the others only where it moves a joint in the first.
  std::vector<Found> pivots_at(const AtEnds& alone) {
    std::vector<std::vector<PivotFit>> fits;  // by place and joint
    for (const JointMoves& moves : alone.moves) fits.emplace_back(moves.begin(), moves.end());
    std::vector<char> tried(fits.size());
    for (std::size_t b = 0; b < bases; ++b) {
      std::vector<std::vector<ControlPlace>> poses;
      std::vector<std::size_t> place_of;
      for (std::size_t i = 0; i < fits.size(); ++i) {
        if (has(base_poses_[b], alone.places[i].first) || (tried[i] && !moves_any(fits[i]))) continue;
        tried[i] = 1;
        place_of.push_back(i);
        poses.push_back(base_poses_[b]);
        poses.back().push_back(alone.places[i]);
      }
      const std::vector<JointMoves> moves = evaluate_joints(rig_, poses, stage, progress_);
      for (std::size_t p = 0; p < poses.size(); ++p)
        for (std::size_t j = 0; j < reaches_.size(); ++j) fits[place_of[p]][j].add(base_moves_[b][j], moves[p][j]);
    }
    std::vector<Found> found;
    for (std::size_t i = 0; i < fits.size(); ++i)
      for (std::size_t j = 0; j < reaches_.size(); ++j)
        if (const auto [pivot, moved, left] = fits[i][j].solve();
            reaches_[j] * moved > tolerance_ && left < most_left * moved)
          found.push_back({j, alone.places[i], pivot});
    return found;
  }

  template <class Fits>
  bool moves_any(const Fits& fits) const {
    for (std::size_t j = 0; j < reaches_.size(); ++j)
      if (reaches_[j] * fits[j].moved() > tolerance_ / 4) return true;
    return false;
  }

  RigEvaluator& rig_;
  const DrivenJoints& driven_;
  Progress& progress_;
  const double tolerance_;
  std::vector<double> reaches_;  // of translations, by joint; 0 where there is no pivot to look for
  std::vector<std::vector<ControlPlace>> base_poses_;
  std::vector<JointMoves> base_moves_;
};

}  // namespace

std::vector<JointComposition> compose_joints(RigEvaluator& rig, double tolerance, Progress& progress) {
  std::vector<JointComposition> compositions(rig.rest().driven.joints.size());
  const AtEnds ends = evaluate_ends(rig, progress);
  OrderSearch(rig, ends, tolerance * rig.diagonal(), progress).run(compositions);
  PivotSearch(rig, tolerance * rig.diagonal(), progress).run(ends, compositions);
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
