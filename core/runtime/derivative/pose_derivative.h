// The derivatives of points of a face, and of frames that follow it, by its controls.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "runtime/derivative/frame_derivatives.h"
#include "runtime/derivative/point_group.h"
#include "runtime/evaluator.h"

namespace fb::runtime {

// What is followed: points, weighted sums of vertices in baked order; sockets and driven joints, by index; at a level
// of detail.
struct Followed {
  std::span<const WeightedPoint> points;
  std::span<const std::uint32_t> sockets = {}, joints = {};
  float lod = 0;
};

// Points of a face and frames in poses, and their derivatives by the controls, see FeatureDerivatives: of the pose as
// it is evaluated, but for what is rounded there to whole steps. Sums have one order, so that they are the same bits on
// every machine. Allocates nothing once it is made. One thread at a time. Refers to the evaluator.
class PoseDerivative {
 public:
  PoseDerivative(const Evaluator& evaluator, const Followed& followed, std::pmr::memory_resource& memory);

  // Controls without NaN; those out of range are clamped. Under with_float_mode().
  void find_positions(const float* controls);
  // The derivatives, too; downwards: see FeatureDerivatives::run.
  void run(const float* controls, const std::uint8_t* downwards = nullptr);

  // All points by groups; those behind the ones asked for are of sockets.
  std::span<const PointGroup> groups() const { return groups_; }
  PointPlace place(std::size_t point) const { return places_[point]; }
  std::array<float, 3> position(std::size_t point) const {
    const PointGroup& group = groups_[places_[point].group];
    const float* const first = group.positions() + places_[point].slot;
    return {first[0], first[group.stride()], first[2 * group.stride()]};
  }
  const FrameDerivatives& frames() const { return frames_; }

 private:
  static std::pmr::vector<WeightedPoint> all_points(const FrameDerivatives& frames,
                                                    std::span<const WeightedPoint> points,
                                                    std::pmr::memory_resource& memory);
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
  FrameDerivatives frames_;
  std::pmr::vector<PointGroup> groups_;
  std::pmr::vector<PointPlace> places_;  // of all points
  JointDerivatives joints_;
  CoefficientDerivatives coefficients_;
  Workspace workspace_;
  std::pmr::vector<float> rows_;  // of the pose, in baked order, before driven joints
};

}  // namespace fb::runtime
