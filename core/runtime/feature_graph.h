// Sparse evaluation of features: only features that can differ from 0 are computed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/packed_model.h"
#include "runtime/csr_table.h"
#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {

class FeatureGraph;

// The feature values of one pose or of a block of poses, by graph index.
class FeatureState {
 public:
  // For up to `poses` poses: 1 or poses_per_block.
  FeatureState(const FeatureGraph& graph, std::size_t poses, std::pmr::memory_resource& memory);
  // The features that are not 0 in at least one pose. All others are 0.
  std::span<const std::uint32_t> active() const { return {active_.data(), active_count_}; }
  // The values of a feature, one a pose.
  const float* operator[](std::size_t feature) const { return values_.data() + feature * poses_; }
  // Values that are not 0, over all poses.
  std::size_t nonzero_count() const { return nonzero_count_; }

 private:
  friend class FeatureGraph;
  std::pmr::vector<float> values_;
  std::pmr::vector<std::uint32_t> active_;
  std::pmr::vector<std::uint32_t> candidates_;  // combined features of one level that may differ from 0
  std::pmr::vector<float> offsets_;             // of controls from rest, clamped, poses interleaved
  std::size_t active_count_ = 0, active_control_features_ = 0;
  std::size_t nonzero_count_ = 0, poses_ = 1;
};

// The features of a model. Features of controls are stored as arrays for vectorised evaluation; combined features
// (products and minima) are evaluated level by level, from the active features of the levels below.
class FeatureGraph {
 public:
  // `heap`: of temporaries.
  FeatureGraph(const PackedModel& model, std::pmr::memory_resource& memory, std::pmr::memory_resource& heap);

  std::size_t control_count() const { return rest_.size(); }
  std::size_t feature_count() const { return graph_index_.size(); }
  // The graph index of one of the model's features. Features of controls come first, in the order of controls.
  std::uint32_t graph_index(std::size_t feature) const { return graph_index_[feature]; }

  // A product or minimum of two features, by graph indices.
  struct Combined {
    std::uint32_t index, first, second;
    Feature::Kind kind;
  };
  // All of them, by ascending index: operands come before what is made of them.
  std::pmr::vector<Combined> combined(std::pmr::memory_resource& memory) const;
  // Features of controls are those below.
  std::size_t control_feature_count() const { return controls_.size(); }
  // One of them: its kind, control, scale, threshold and fall.
  Feature control_feature_at(std::size_t feature) const {
    return {kinds_[feature], controls_[feature], scales_[feature], thresholds_[feature], falls_[feature]};
  }
  // Of a control.
  float minimum(std::size_t control) const { return minimum_[control]; }
  float maximum(std::size_t control) const { return maximum_[control]; }
  float rest(std::size_t control) const { return rest_[control]; }

  // EVALUATION.md, "Clamp" and "Features". Lists the active features in `state`: features of controls first, in order.
  // The controls of pose p are at controls + p * stride; `poses` is 1 or poses_per_block. Returns how many control
  // values were out of range.
  std::uint64_t run(const PoseKernels& kernels, const float* controls, std::size_t stride, std::size_t poses,
                    FeatureState& state) const;

 private:
  void add_control_features(const PackedModel& model, std::pmr::memory_resource& heap);
  void add_combined_features(const PackedModel& model, std::pmr::memory_resource& heap);
  template <std::size_t poses>
  class ActiveList;
  template <std::size_t poses>
  std::uint64_t run_poses(const PoseKernels& kernels, const float* controls, std::size_t stride,
                          FeatureState& state) const;
  template <std::size_t poses>
  void run_combined(FeatureState& state, ActiveList<poses>& active) const;

  std::pmr::vector<std::uint32_t> graph_index_;
  std::pmr::vector<float> minimum_, maximum_, rest_;  // by control
  // Features of controls.
  std::pmr::vector<std::uint32_t> controls_;
  std::pmr::vector<Feature::Kind> kinds_;
  std::pmr::vector<float> scales_, thresholds_, falls_;
  // A combined feature can differ from 0 only if both operands do. It is listed in the row of its deeper operand;
  // other_operand_ has the other one, by entry.
  CsrTable<Combined> combined_;
  std::pmr::vector<std::uint32_t> other_operand_;
  // Exception: minima of features that can be negative are evaluated in every pose. Rows are levels: features of
  // controls are level 0; a combined feature is one above its deeper operand.
  CsrTable<Combined> always_evaluated_;
};

}  // namespace fb::runtime
