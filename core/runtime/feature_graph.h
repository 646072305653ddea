// From controls to the features that are not 0: what rests costs next to nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/packed_model.h"
#include "runtime/kernels/panel_kernels.h"

namespace fb::runtime {

class FeatureGraph;

// The features of one pose, or of the poses of a block, by the graph's own numbers. Those not listed are 0.
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
  std::pmr::vector<std::uint32_t> active_;
  std::pmr::vector<std::uint32_t> candidates_;  // combined features that may be other than 0
  std::pmr::vector<float> moves_;               // of controls, within their ranges, those of poses side by side
  std::size_t count_ = 0, of_controls_ = 0;     // of those listed
  std::size_t moved_count_ = 0, poses_ = 1;
};

// The features of a model, arranged so that those of controls are computed side by side, and what is made of features
// that are 0 is not looked at.
class FeatureGraph {
 public:
  FeatureGraph(const PackedModel& model, std::pmr::memory_resource& memory);

  std::size_t control_count() const { return rest_.size(); }
  std::size_t feature_count() const { return numbers_.size(); }
  // The number that one of the model's features has here: those of controls come first, control after control.
  std::uint32_t number(std::size_t feature) const { return numbers_[feature]; }

  // FORMAT.md, "Clamp" and "Features": leaves in `state` the features that are not 0, those of controls first and in
  // the order of controls. Pose p's controls are at controls + p * stride; `poses` is 1 or block_poses. Returns how
  // many controls were beyond their range.
  std::uint64_t run(const PoseKernels& kernels, const float* controls, std::size_t stride, std::size_t poses,
                    FeatureState& state) const;

 private:
  template <std::size_t poses>
  std::uint64_t run_poses(const PoseKernels& kernels, const float* controls, std::size_t stride,
                          FeatureState& state) const;
  struct Combined {
    std::uint32_t index, first, second;
    Feature::Kind kind;
  };

  std::pmr::vector<std::uint32_t> numbers_;
  std::pmr::vector<float> minimum_, maximum_, rest_;  // of controls
  // Of controls' features.
  std::pmr::vector<std::uint32_t> controls_;
  std::pmr::vector<Feature::Kind> kinds_;
  std::pmr::vector<float> scales_, thresholds_, falls_;
  // A combined feature can only be other than 0 if the one it is listed under is: of its two the one that is itself
  // combined more deeply.
  std::pmr::vector<Combined> combined_;             // feature after feature
  std::pmr::vector<std::uint32_t> combined_begin_;  // in combined_; one more than features
  std::pmr::vector<std::uint32_t> other_;           // of a combined feature's two the one it is not listed under
  // But for minima of features that may be below 0: those are taken in every pose, level after level. Level 0 are
  // features of controls, each other is one more than the deeper of its two.
  std::pmr::vector<Combined> always_;
  std::pmr::vector<std::uint32_t> always_begin_;  // in always_, by level; one more than levels
};

}  // namespace fb::runtime
