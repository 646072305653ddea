// Finds controls whose pose comes near to targets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "runtime/solve/box_minimum.h"
#include "runtime/solve/solve_residuals.h"

namespace fb::runtime {

// What a solution is beside near to its targets. A difference of points or distances counts as (difference / noise)^2 /
// 2 times its weight; controls are told in units of their ranges.
struct SolvePreferences {
  double noise = 1;                       // in units of the face: what differences of targets are of themselves
  float nearness = 0;                     // times (control - near)^2 / 2
  float sparsity = 0;                     // times |control - rest|: few controls rather than many
  float smoothness = 0;                   // times (control - before)^2 / 2
  float symmetry = 0;                     // times (control - its mirror's)^2 / 2, both from rest
  const float* near = nullptr;            // values of controls; null: rest
  const float* before = nullptr;          // values of controls; null: smoothness does not count
  const std::uint8_t* movable = nullptr;  // by control: whether it may move from where it starts; null: all
  bool find_motion = false;               // of the target's space, see SolveResiduals::set_motion
  unsigned most_iterations = 20;
  float tolerance = 1e-4f;  // ends where an iteration lowers what is minimised by less than this share
};

struct SolveResult {
  unsigned iterations = 0;  // how often derivatives were found
  bool converged = false;   // it did not end because of most_iterations
  double objective = 0;
};

// Minimises the sum of all that SolvePreferences lists, with controls within their ranges: Gauss-Newton steps, damped
// as by Levenberg and Marquardt, of the unknowns that are not held at an end of their ranges, or at rest where sparsity
// holds them, by the gradient (projected Newton steps: Bertsekas, SIAM J. Control Optim. 20, 1982). Allocates nothing
// once it is made; the same bits on every machine. Under with_float_mode().
class PoseSolver {
 public:
  PoseSolver(const Evaluator& evaluator, const Followed& followed, std::span<const PointPair> pairs,
             std::pmr::memory_resource& memory);

  const SolveResiduals& residuals() const { return residuals_; }
  PoseDerivative& derivative() { return residuals_.derivative(); }
  const PoseDerivative& derivative() const { return residuals_.derivative(); }

  // controls, in and out: where it starts, without NaN, and the solution; motion: likewise.
  SolveResult solve(const SolveTargets& targets, const SolvePreferences& preferences, float* controls,
                    RigidMotion& motion);

  // By control, of the solution just found: the share of what determines it that comes from the targets, 0 to 1. With
  // nearness, smoothness and symmetry of 0, of a preference for rest of 1.
  void find_decided(const SolvePreferences& preferences, float* decided);

 private:
  double preference_cost(const SolvePreferences& preferences, const float* places) const;
  void find_gradient(const SolvePreferences& preferences);
  void choose_unknowns(const SolvePreferences& preferences);
  void set_box(const SolvePreferences& preferences);
  void add_preference_products(const SolvePreferences& preferences);
  void linearise(const SolvePreferences& preferences);
  bool advance(const SolvePreferences& preferences, double& objective, RigidMotion& motion);
  bool step(const SolvePreferences& preferences, SolveResult& result, RigidMotion& motion);
  void take_step(const SolvePreferences& preferences, const RigidMotion& motion);
  void set_controls(const float* places, float* controls) const;
  float place(std::size_t control, float value) const;

  const RigSchema& schema_;
  SolveResiduals residuals_;
  BoxMinimum box_;
  std::pmr::vector<std::uint32_t> mirrors_;     // by control; itself where it has none
  std::pmr::vector<float> lower_, upper_;       // by control: ends of its range less rest, in units of the range
  std::pmr::vector<float> places_, tried_;      // of controls: less rest, in units of their ranges
  std::pmr::vector<float> near_, before_;       // likewise
  std::pmr::vector<float> gradient_;            // by unknown
  std::pmr::vector<std::uint32_t> unknowns_;    // that a step moves, ascending
  std::pmr::vector<std::uint32_t> unknown_of_;  // by control, its place there, or UINT32_MAX
  std::pmr::vector<std::uint8_t> downwards_;    // by control that can move to both sides of rest: which one is tried
  std::pmr::vector<std::uint8_t> below_;        // by control, whether the step is on the lower side of rest
  std::pmr::vector<BoxMinimum::Held> held_;     // by control, in the last step
  std::pmr::vector<float> controls_;
  bool other_sides_ = false;  // whether a control at rest is to try the other side
  RigidMotion tried_motion_;
  float damping_ = 0;
};

}  // namespace fb::runtime
