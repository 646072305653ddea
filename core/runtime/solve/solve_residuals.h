#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "runtime/derivative/pose_derivative.h"
#include "runtime/solve/rigid_motion.h"

namespace fb::runtime {

// Two points, by number, whose distance has a target.
struct PointPair {
  std::uint32_t first, second;
};

// What a pose should come to: where points and frames should be, and how far points should be from each other. Weights
// are 0 or more.
struct SolveTargets {
  const float* points = nullptr;            // 3 floats a point, in the space of a target
  const float* point_weights = nullptr;     // one a point; null: 1
  const float* distances = nullptr;         // one a pair
  const float* distance_weights = nullptr;  // one a pair; null: 1
  const float* frames = nullptr;            // 12 floats a frame, in the space of a target
  const float* frame_weights = nullptr;     // one a frame; null: 1
};

// The differences of points, distances and frames from targets, each times the root of its weight, and their
// derivatives by the unknowns: controls, in units of their ranges, and behind them a small rotation and a translation,
// in the space of positions, of where the target's space is. The axes of a frame count as points at arm's length: a
// quarter of the face's diagonal from its origin.
class SolveResiduals {
 public:
  static constexpr std::size_t motion_unknowns = 6;

  SolveResiduals(const Evaluator& evaluator, const Followed& followed, std::span<const PointPair> pairs,
                 std::pmr::memory_resource& memory);

  PoseDerivative& derivative() { return pose_; }
  const PoseDerivative& derivative() const { return pose_; }

  // noise: what a difference is told in, above 0. Numbers are finite.
  void set_targets(const SolveTargets& targets, double noise);
  // Where the target's space is: it has at motion(x) what the face has at x.
  void set_motion(const RigidMotion& motion);

  // Half the sum of squares, of a pose.
  double find(const float* controls);
  // The same, and derivatives of that pose; downwards: see FeatureDerivatives::run.
  double run(const float* controls, const std::uint8_t* downwards);

  // Adds the derivatives of half the sum of squares by the unknowns.
  void add_gradient(bool motion, float* gradient) const;
  // Adds the products of derivatives of some unknowns, ascending, to the lower triangle of a matrix.
  void add_products(std::span<const std::uint32_t> unknowns, float* matrix, std::size_t stride);

  // Of the last pose: where a point is, less where it should be, in units of the face; 0 where its weight is 0.
  std::array<float, 3> difference(std::size_t point) const;
  bool counts(std::size_t point) const { return weight(point) > 0; }

 private:
  // Rows of residuals that depend on the same controls.
  struct Rows {
    Rows(std::size_t length, std::pmr::memory_resource& memory)
        : targets(length, &memory),
          scales(length, &memory),
          residuals(length, &memory),
          pulls(length, &memory),
          motion(motion_unknowns * length, &memory),
          counting(&memory) {
      counting.reserve(length);
    }
    std::pmr::vector<float> targets, scales;   // where the face is; the root of weights over the noise
    std::pmr::vector<float> residuals;         // scaled
    std::pmr::vector<float> pulls;             // times the scale once more
    std::pmr::vector<float> motion;            // derivatives of differences by the motion, one unknown after the other
    std::pmr::vector<std::uint32_t> counting;  // the rows whose scale is above 0
  };
  double half_of_squares(Rows& rows, const float* values) const;
  double half_of_squares();
  float weight(std::size_t point) const;
  void place_vector(Rows& rows, const RigidMotion& motion, const float* given, const std::size_t (&at)[3],
                    bool direction) const;
  void find_extra_values();
  void find_extra_derivatives();
  void add_products_of(const Rows& rows, std::span<const std::uint32_t> controls, const float* first,
                       std::span<const std::uint32_t> unknowns, float* matrix, std::size_t stride);

  const PoseKernels& kernels_;
  PoseDerivative pose_;
  std::pmr::vector<float> lengths_;  // of the ranges of controls
  std::size_t point_count_;
  float arm_;
  std::pmr::vector<PointPair> pairs_;
  std::pmr::vector<Rows> rows_;                   // by group, then of distances and frames
  std::pmr::vector<float> given_, given_frames_;  // targets in their space
  std::pmr::vector<std::uint32_t> all_controls_;
  std::pmr::vector<float> extra_values_, by_control_;  // of distances and frames; derivatives of all by each control
  std::pmr::vector<float> gathered_, by_row_, sums_;   // derivatives by unknown and by row; a few rows of products
  std::pmr::vector<std::uint32_t> unknown_places_;
};

}  // namespace fb::runtime
