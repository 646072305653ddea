#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <optional>
#include <vector>

#include "model/packed_model.h"
#include "runtime/panel_matrix.h"
#include "runtime/quantise.h"

namespace fb::runtime {

// The network of a region, with its matrices laid out for evaluation. Immutable after find_rest().
class RegionNetwork {
 public:
  RegionNetwork(const PoseKernels& kernels, const PackedRegion& region, std::pmr::memory_resource& memory);

  // Computes the outputs at rest, which run() subtracts. Fails with not_finite, naming the region. `heap`: of
  // temporaries.
  void find_rest(const PoseKernels& kernels, const char* name, std::pmr::memory_resource& heap);

  std::size_t input_count() const { return layers_.front().inputs; }
  // Of an input of the first layer, see PanelMatrix::offset.
  std::uint32_t input_offset(std::size_t input) const { return layers_.front().low.offset(input); }
  // The input at that offset.
  std::size_t input_at(std::uint32_t offset) const { return layers_.front().low.column_at(offset); }
  std::size_t output_count() const { return layers_.back().outputs; }
  std::size_t max_width() const;  // of any layer's input or output
  // Floats of `work` that run() needs for each pose.
  std::size_t work_size() const { return 2 * (max_width() + padding); }

  // EVALUATION.md, "Regions", without the gate. input: sparse inputs of the first layer, in 1 or poses_per_block poses;
  // all others are 0. work: poses * work_size() floats. buffers: for max_width() inputs. outputs: the first `count` <=
  // output_count(), times poses: output o of pose p at o * poses + p.
  void run(const PoseKernels& kernels, const MatrixInputs& input, std::size_t poses, std::size_t count, float* work,
           QuantiseBuffers& buffers, float* outputs) const;

  // What a layer computes: y = activation(W x + bias), plus x if `skip`.
  struct LayerForm {
    std::uint32_t inputs, outputs;
    Activation activation;
    bool skip;
  };
  std::size_t layer_count() const { return layers_.size(); }
  LayerForm layer_form(std::size_t layer) const {
    const Layer& of = layers_[layer];
    return {of.inputs, of.outputs, of.activation, of.skip};
  }
  // Writes a layer's weights, the rows of its outputs `stride` floats apart, and its bias.
  void copy_layer(std::size_t layer, std::size_t stride, float* weights, float* bias) const;

 private:
  struct Layer {
    Layer(const PoseKernels& kernels, const PackedLayer& layer, PanelMatrix::Form form,
          std::pmr::memory_resource& memory);
    // Computes the first `count` outputs, or some more. input: the floats that x was made from, for skip layers. Poses
    // are `stride` floats apart in input and output.
    void run(const PoseKernels& kernels, const QuantisedInputs& x, std::size_t stride, std::size_t count,
             const float* input, float* output) const;
    void join_digits(const PoseKernels& kernels, const QuantisedInputs& x, std::uint32_t first,
                     float* const* rows) const;
    std::uint32_t inputs, outputs;
    Activation activation;
    bool skip;
    PanelMatrix low;
    std::optional<PanelMatrix> high;       // the high digits of a wide layer
    float limit;                           // see PanelMatrix::limit
    std::pmr::vector<float> scales, bias;  // padded
  };
  std::pmr::vector<Layer> layers_;
  std::pmr::vector<float> rest_outputs_;
};

}  // namespace fb::runtime
