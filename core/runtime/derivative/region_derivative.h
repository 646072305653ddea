#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "runtime/derivative/feature_derivatives.h"
#include "runtime/evaluation_layout.h"

namespace fb::runtime {

// The derivatives of weighted sums of the coefficients of a region by the controls: of its network with weights as
// floats, whose inputs are not rounded, and its gate.
class RegionDerivative {
 public:
  // sums: the weights of each, one a coefficient.
  RegionDerivative(const EvaluationLayout& layout, std::size_t region, const FeatureDerivatives& features,
                   std::span<const float> sums, std::pmr::memory_resource& memory);

  void run(const PoseKernels& kernels, const FeatureDerivatives& features);

  // The controls that the region depends on, ascending.
  std::span<const std::uint32_t> controls() const { return controls_; }
  // By each of them, of a sum.
  std::span<const float> of(std::size_t index) const {
    return std::span(derivatives_).subspan(index * control_stride_, controls_.size());
  }

 private:
  struct Layer {
    Layer(const RegionNetwork& network, std::size_t number, std::pmr::memory_resource& memory);
    RegionNetwork::LayerForm form;
    std::size_t stride;               // of weights
    std::pmr::vector<float> weights;  // by output
    std::pmr::vector<float> bias, slopes;
  };
  // What depends on a feature, by the place of its controls in controls_.
  struct FeatureControls {
    std::uint32_t feature, first;  // first: in places_
  };

  void add_features(const EvaluationLayout& layout, std::size_t region, const FeatureDerivatives& features);
  void run_network(const PoseKernels& kernels);
  void start_rows(const PoseKernels& kernels);
  void pull_back(const PoseKernels& kernels);
  float gate(const FeatureDerivatives& features);
  void add_feature(const FeatureDerivatives& features, const FeatureControls& of, float factor, float* to) const;

  float gate_slope_;
  std::pmr::vector<Layer> layers_;
  std::size_t outputs_, output_stride_, count_;  // of the network; padded; sums
  std::pmr::vector<float> sums_;                 // count_ x output_stride_
  std::pmr::vector<FeatureControls> inputs_, gate_features_;
  std::pmr::vector<std::uint32_t> controls_, places_;
  std::size_t control_stride_ = 0, width_ = 0;  // width_: of the widest layer, padded
  std::pmr::vector<float> values_, next_;       // of a layer's inputs and outputs
  std::pmr::vector<float> rest_outputs_, sum_values_;
  std::pmr::vector<float> by_last_;  // of each sum, by what goes into the last layer: sums x width_
  std::pmr::vector<float> by_inputs_, work_;
  std::pmr::vector<float> by_gate_;      // of the gate value, by control
  std::pmr::vector<float> derivatives_;  // sums x control_stride_
};

}  // namespace fb::runtime
