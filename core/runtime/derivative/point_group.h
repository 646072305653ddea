#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "runtime/derivative/basis_rows.h"
#include "runtime/derivative/joint_derivatives.h"
#include "runtime/evaluation_layout.h"

namespace fb::runtime {

// A weighted sum of up to three vertices, in baked order. Vertices with a weight of 0 do not count.
struct WeightedPoint {
  std::array<std::uint32_t, 3> vertices;
  std::array<float, 3> weights;
};

// Points that use the same row blocks: where they are in a pose, and their derivatives by the controls. Numbers of
// points are by axis: those of axis a begin at a * stride(), one a point; padding is 0.
class PointGroup {
 public:
  // numbers: of the points of the group among `points`.
  PointGroup(const EvaluationLayout& layout, const DetailChoice& choice, std::span<const WeightedPoint> points,
             std::span<const std::uint32_t> numbers, std::pmr::memory_resource& memory);

  // The rows of the basis that are needed.
  BasisRows& rows() { return rows_; }
  void mark_joints(std::span<std::uint8_t> wanted) const;
  // To be called once.
  void find_controls(const CoefficientDerivatives& coefficients, const JointDerivatives& joints);

  // Positions; rows: those of a pose in baked order, before driven joints move them.
  void find_positions(const float* rows, const JointDerivatives& joints);
  // Derivatives, after the positions of the same pose.
  void run(const PoseKernels& kernels, const CoefficientDerivatives& coefficients, const JointDerivatives& joints);

  std::span<const std::uint32_t> numbers() const { return numbers_; }
  std::size_t stride() const { return stride_; }
  std::size_t length() const { return 3 * stride_; }
  const float* positions() const { return positions_.data(); }
  // The controls that the points depend on, ascending, and the derivatives by controls()[index], length() floats.
  std::span<const std::uint32_t> controls() const { return rows_.controls(); }
  const float* by_control(std::size_t index) const {
    return of_points_.empty() ? rows_.by_control(index) : of_points_.data() + index * length();
  }

 private:
  // A part of a point: vertices that follow the same joints, with the same weights.
  struct Part {
    std::uint32_t point;                     // within the group
    std::uint32_t first_vertex, end_vertex;  // in part_vertices_
    std::uint32_t first_joint, end_joint;    // in part_joints_
    float weight;                            // the sum of those of its vertices
  };
  struct PartVertex {
    std::uint32_t vertex;
    float weight;
  };
  // What parts follow a joint.
  struct FollowedJoint {
    std::uint32_t joint;
    std::pmr::vector<float> rows;  // three axes of parts and what moves with the origin, by weight: 4 x stride
    std::pmr::vector<std::uint32_t> places;  // of the joint's controls in those of the group
  };

  void add_parts(const EvaluationLayout& layout, const WeightedPoint& point, std::uint32_t number);
  BasisRows rows_of_parts(const EvaluationLayout& layout, const DetailChoice& choice,
                          std::pmr::memory_resource& memory) const;
  void follow_joints(const PoseKernels& kernels, const JointDerivatives& joints);
  void turn(std::size_t control);

  std::pmr::vector<std::uint32_t> numbers_;
  std::pmr::vector<Part> parts_;
  std::pmr::vector<PartVertex> part_vertices_;
  std::pmr::vector<JointInfluence> part_joints_;  // by index of the joint
  std::size_t stride_ = 0, part_stride_ = 0;
  BasisRows rows_;  // of parts, by axis
  std::pmr::vector<FollowedJoint> followed_;
  std::pmr::vector<float> turns_;      // by entry of the sum of what joints do to a part, 9 x part_stride_
  std::pmr::vector<float> of_points_;  // derivatives; empty where a point is a part
  std::pmr::vector<float> places_, positions_, work_;  // places_: of parts, before joints
};

}  // namespace fb::runtime
