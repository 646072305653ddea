// The derivatives of points of a face by its controls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "runtime/derivative/point_group.h"
#include "runtime/evaluator.h"

namespace fb::runtime {

// Points of a face in poses, and their derivatives by the controls, see FeatureDerivatives: of the pose as it is
// evaluated, but for what is rounded there to whole steps. Sums have one order, so that they are the same bits on every
// machine. Allocates nothing once it is made. One thread at a time. Refers to the evaluator.
class PoseDerivative {
 public:
  // points: weighted sums of vertices in baked order; lod: the level of detail.
  PoseDerivative(const Evaluator& evaluator, std::span<const WeightedPoint> points, float lod,
                 std::pmr::memory_resource& memory);

  // Controls without NaN; those out of range are clamped. Under with_float_mode().
  void find_positions(const float* controls);
  // The derivatives, too.
  void run(const float* controls);

  // The points by groups, each of one or more.
  std::span<const PointGroup> groups() const { return groups_; }
  const JointDerivatives& joints() const { return joints_; }

 private:
  static std::pmr::vector<PointGroup> make_groups(const EvaluationLayout& layout, const DetailChoice& choice,
                                                  std::span<const WeightedPoint> points,
                                                  std::pmr::memory_resource& memory);
  JointDerivatives make_joints(std::pmr::memory_resource& memory) const;
  CoefficientDerivatives make_coefficients(std::pmr::memory_resource& memory);
  template <class Visit>
  void visit_rows(const Visit& visit);

  const EvaluationLayout& layout_;
  float lod_;
  DetailChoice choice_;
  std::pmr::vector<PointGroup> groups_;
  JointDerivatives joints_;
  CoefficientDerivatives coefficients_;
  Workspace workspace_;
  std::pmr::vector<float> rows_;  // of the pose, in baked order, before driven joints
};

}  // namespace fb::runtime
