#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"

namespace fb::bake {

// Controls of one group of the schema; all controls without a group are one more.
struct ControlGroup {
  std::string name;
  std::vector<std::size_t> controls;
  double energy = 0;  // its share of the motion of single controls; shares sum to 1
};

// The groups of a rig's controls in the order they first occur, with equal shares of energy.
std::vector<ControlGroup> control_groups(const RigSchema& schema);

// How a rig responds to each control alone: at 0, 1/4, ... 1 of its range, the others at rest; where the rig's budget
// is below 20 poses a control, at both ends only. All distances are root mean squares over (at most a thousand)
// vertices, over the diagonal.
class ControlResponses {
 public:
  static constexpr std::size_t most_values = 5;

  // Evaluates 5 or 2 poses of each control; notes controls that move nothing. `budget`: poses of the rig that sampling
  // may ask for; 0: no limit. Without one, also closes in on the jumps of controls that are much steeper between two of
  // their poses than beside them.
  ControlResponses(RigEvaluator& rig, std::uint64_t budget, Progress& progress);
  // Of a rig that nobody can ask: as if all controls moved alike, in straight lines and apart from each other. Within a
  // budget, the values that would be evaluated count as answered, so that plans hold them.
  ControlResponses(const RigSchema& schema, std::uint64_t budget);

  // Where the rig has a budget, the answers are data: the values of each control that were evaluated. Else none.
  const std::vector<float>& answered(std::size_t control) const { return answered_[control]; }
  // How many values of all controls are evaluated, besides rest, within a budget (0: no limit).
  static std::size_t poses_within(const RigSchema& schema, std::uint64_t budget);

  const std::vector<ControlGroup>& groups() const { return groups_; }
  // The largest distance of the mesh from rest.
  double motion(std::size_t control) const { return motion_[control]; }
  // The second difference |f(t-1/4) - 2 f(t) + f(t+1/4)| at t = 1/4, 1/2, 3/4 of the range; 0 where it is not known.
  const std::array<double, 3>& bend(std::size_t control) const { return bend_[control]; }
  // Values between which the rig jumps, each pair as near as floats are: inside, nearer to rest, and outside.
  const std::vector<std::array<float, 2>>& jumps(std::size_t control) const { return jumps_[control]; }
  // True if the two controls, moved from rest to these ends of their ranges, push the same vertices in opposite
  // directions. Known for controls of one group only; false otherwise.
  bool opposed(std::size_t a, bool a_up, std::size_t b, bool b_up) const {
    return opposed_[(2 * a + a_up) * 2 * motion_.size() + 2 * b + b_up] != 0;
  }

 private:
  void measure(const Source& rig, std::size_t control, const float* responses);
  void find_jumps(RigEvaluator& rig, std::size_t control, EvaluationStage& stage);
  void find_groups(const RigSchema& schema);
  void find_opposed();

  std::size_t values_ = 0;  // evaluated of each control
  std::vector<std::vector<float>> answered_;
  std::vector<ControlGroup> groups_;
  std::vector<double> motion_;
  std::vector<std::array<double, 3>> bend_;
  std::vector<std::uint8_t> steep_;  // controls that may jump
  std::vector<std::vector<std::array<float, 2>>> jumps_;
  std::vector<std::vector<float>> directions_;  // displacement at both ends (2 c: minimum, 2 c + 1: maximum), length 1
  std::vector<std::uint8_t> opposed_;
  double diagonal_ = 1;
};

}  // namespace fb::bake
