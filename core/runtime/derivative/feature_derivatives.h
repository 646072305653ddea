#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "runtime/feature_graph.h"

namespace fb::runtime {

// The features of a pose, and their derivatives by the controls. Where a feature bends, the derivative is that of the
// side to which the control moves: upwards, unless it is asked for the other one, or its range ends there. That of a
// control outside of its range is 0, as is what it is clamped to.
class FeatureDerivatives {
 public:
  FeatureDerivatives(const FeatureGraph& graph, std::pmr::memory_resource& memory);

  // Finds them for controls without NaN. downwards: by control, whether the other side is asked for; null: of none.
  void run(const PoseKernels& kernels, const float* controls, const std::uint8_t* downwards);

  // By graph index. A feature has derivatives by the controls that it is made of, which ascend.
  float value(std::size_t feature) const { return *state_[feature]; }
  std::span<const std::uint32_t> controls(std::size_t feature) const {
    return std::span(controls_).subspan(first_[feature], first_[feature + 1] - first_[feature]);
  }
  std::span<const float> of(std::size_t feature) const {
    return std::span(derivatives_).subspan(1 + first_[feature], first_[feature + 1] - first_[feature]);
  }
  // The side to which a control moves: 1 or -1; 0 outside of its range.
  float direction(std::size_t control) const { return directions_[control]; }

 private:
  void add_combined(const FeatureGraph::Combined& combined);

  const FeatureGraph& graph_;
  FeatureState state_;
  std::pmr::vector<float> directions_, offsets_;  // by control: offsets from rest
  std::pmr::vector<FeatureGraph::Combined> combined_;
  std::pmr::vector<std::uint32_t> first_;     // by feature, and one more: in controls_
  std::pmr::vector<std::uint32_t> controls_;  // of all features
  std::pmr::vector<float> derivatives_;       // a 0, then one for each of controls_
  // The derivatives of both operands by a control of a combined feature, in derivatives_: behind those of control
  // features.
  struct Operands {
    std::uint32_t first, second;
  };
  std::pmr::vector<Operands> operands_;
};

}  // namespace fb::runtime
