#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bake/linalg/gemm.h"
#include "model/network.h"

namespace fb::bake {

// Constants of one step of Adam.
struct AdamStep {
  float step_size;                 // learning rate / (1 - beta1^t)
  float second_moment_correction;  // 1 / sqrt(1 - beta2^t)
  float beta1, beta2, epsilon;
  float decay_factor;  // of the parameters: 1 - learning rate * weight decay
};

// A block of coordinates, or a value in as many poses.
struct alignas(64) SixteenFloats {
  static constexpr std::size_t count = 16;
  float values[count];
};

// The inner loops of baking, on the calling thread. Matrices are column-major, one column a pose.
struct Kernels {
  decltype(&bake::gemm) gemm;
  // The same with both factors rounded to bf16 (8 significant bits) and sums in float, where the processor has products
  // of that kind; elsewhere gemm itself.
  decltype(&bake::gemm) gemm_bf16;
  // y = activation(y + bias) + skip; `derivative` becomes the activation's derivative at y + bias. skip and derivative
  // may be null.
  void (*activation_forward)(Activation activation, std::size_t rows, std::size_t columns, const float* bias,
                             const float* skip, float* y, float* derivative);
  // gradient *= derivative, and bias_gradient += the sum of its columns. The incoming gradient is first copied to
  // skip_gradient where that is not null.
  void (*activation_backward)(std::size_t rows, std::size_t columns, const float* derivative, float* gradient,
                              float* skip_gradient, float* bias_gradient);
  // Adam with decoupled weight decay on `count` parameters from `first`. The gradients of the microbatches are summed
  // in their order.
  void (*adam)(const AdamStep& step, std::size_t first, std::size_t count, const float* const* gradients,
               std::size_t microbatches, float* parameters, float* mean, float* square);
  // Quantises and dequantises one row of weights as packing does: multiples of max|row| / levels.
  void (*quantise_row)(std::size_t count, float levels, const float* row, float* quantised);
  // The sums of one block of blendshapes in a few poses, see BlockedBlendshapes. terms: `count` of the block's shapes;
  // features and offsets: of all of them; values: in the poses, of all features; sums: of each pose.
  void (*add_up_block)(std::size_t count, const std::uint32_t* terms, const std::uint32_t* features,
                       const SixteenFloats* offsets, const SixteenFloats* values, SixteenFloats* sums);
};

// The kernels for each instruction set of this processor, widest vectors first.
const std::vector<Kernels>& supported_kernels();

// Those for the widest vectors: same bits on the same kind of processor.
const Kernels& kernels();

}  // namespace fb::bake
