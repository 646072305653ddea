// From controls to the features that are not 0: what rests costs nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/packed_model.h"
#include "runtime/kernels/panel_kernels.h"

namespace fb {

class FeatureGraph;

// The features of one pose, or of the poses of a block. Values of those not listed are 0.
class FeatureState {
 public:
  FeatureState(const FeatureGraph& graph, std::pmr::memory_resource& memory);
  // Those that are not 0 in every pose.
  std::span<const std::uint32_t> active() const { return {active_.data(), count_}; }
  // A feature's values, pose after pose.
  const float* operator[](std::size_t feature) const { return values_.data() + feature * poses_; }
  // How many values are not 0, of all poses.
  std::size_t moved_values() const { return moved_count_; }

 private:
  friend class FeatureGraph;
  std::pmr::vector<float> values_;
  std::pmr::vector<std::uint32_t> active_, moved_controls_;
  std::pmr::vector<std::uint8_t> is_active_;    // by feature
  std::pmr::vector<std::uint32_t> candidates_;  // combined features that may be other than 0
  std::pmr::vector<float> controls_;            // within their ranges, pose after pose
  std::pmr::vector<std::uint32_t> is_moved_;    // by control, in any pose
  std::size_t count_ = 0, moved_count_ = 0, poses_ = 1;
};

// The features of a model, arranged so that controls at rest, and what is made of them, are not looked at.
class FeatureGraph {
 public:
  FeatureGraph(const PackedModel& model, std::pmr::memory_resource& memory);

  std::size_t control_count() const { return rest_.size(); }
  std::size_t feature_count() const { return feature_count_; }

  // FORMAT.md, "Clamp" and "Features": leaves in `state` the features that are not 0, those of controls first and in
  // the order of controls. Pose p's controls are at controls + p * stride; `poses` is 1 or block_poses. Returns how
  // many controls were beyond their range.
  std::uint64_t run(const float* controls, std::size_t stride, std::size_t poses, FeatureState& state) const;

 private:
  // One pose's controls within their ranges; sets is_moved to 1 where they are not at rest. Returns how many were
  // beyond.
  std::uint64_t clamp(const float* controls, float* within, std::uint32_t* is_moved) const;
  template <std::size_t poses>
  std::uint64_t run_poses(const float* controls, std::size_t stride, FeatureState& state) const;
  struct ControlFeature {
    Feature feature;
    std::uint32_t index;
  };
  struct Combined {
    std::uint32_t index, first, second;
    Feature::Kind kind;
  };

  std::size_t feature_count_;
  std::pmr::vector<float> minimum_, maximum_, rest_;  // of controls
  std::pmr::vector<ControlFeature> of_controls_;      // control after control
  std::pmr::vector<std::uint32_t> control_begin_;     // in of_controls_; one more than controls
  // A combined feature can only be other than 0 if the one it is listed under is: of its two the one that is itself
  // combined more deeply.
  std::pmr::vector<Combined> combined_;             // feature after feature
  std::pmr::vector<std::uint32_t> combined_begin_;  // in combined_; one more than features
  std::pmr::vector<std::uint32_t> other_;           // of a combined feature's two the one it is not listed under
  // But for minima of features that may be below 0: those are taken in every pose, level after level. Level 0 are
  // features of controls, each other is one more than the deeper of its two.
  std::pmr::vector<Combined> restless_;
  std::pmr::vector<std::uint32_t> restless_begin_;  // in restless_, by level; one more than levels
};

}  // namespace fb
