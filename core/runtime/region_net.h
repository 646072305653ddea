// A region's network.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <optional>
#include <vector>

#include "model/packed_model.h"
#include "runtime/kernels/panel_kernels.h"
#include "runtime/panel_matrix.h"
#include "runtime/quantized.h"

namespace fb::runtime {

class RegionNet {
 public:
  RegionNet(const PackedRegion& region, std::pmr::memory_resource& memory);

  std::size_t input_count() const { return layers_.front().inputs; }
  std::size_t output_count() const { return layers_.back().outputs; }
  // Of any layer's input or output.
  std::size_t widest() const;

  // How many floats run() works in for each pose.
  std::size_t work_size() const { return 2 * (widest() + padding); }

  // FORMAT.md, "Regions", without the gate: output_count() numbers for each pose, those of poses side by side. The
  // input of the first layer is a list of numbers and their places; all others are 0. `work` are poses * work_size()
  // floats.
  void run(const PoseKernels& kernels, const PoseNumbers& input, std::size_t poses, float* work,
           LayerInputs& layer_inputs, float* outputs) const;

  // Finds what the layers give at rest, which run() subtracts. Fails with not_finite.
  void find_rest(const PoseKernels& kernels, const char* name);

 private:
  struct Layer {
    Layer(const PackedLayer& layer, PanelMatrix::Form form, std::pmr::memory_resource& memory);
    // Of quantised numbers; `input` are those numbers, for layers that skip. Poses lie `stride` apart.
    void run(const PoseKernels& kernels, const Quantized& x, std::size_t poses, std::size_t stride, const float* input,
             float* output) const;
    std::uint32_t inputs, outputs;
    Activation activation;
    bool skip;
    PanelMatrix low;
    std::optional<PanelMatrix> high;  // the other digits of a wide layer
    float limit;
    std::pmr::vector<float> scales, bias;
  };
  std::pmr::vector<Layer> layers_;
  std::pmr::vector<float> at_rest_;  // what the last layer gives there
};

}  // namespace fb::runtime
