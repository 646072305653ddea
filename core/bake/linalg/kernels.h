#pragma once

#include <cstddef>

#include "bake/linalg/gemm.h"
#include "model/network.h"

namespace fb::bake {

// Adam's numbers of one step.
struct AdamStep {
  float rate;             // learning rate / (1 - beta1^t)
  float root_correction;  // 1 / sqrt(1 - beta2^t)
  float beta1, beta2, epsilon;
  float decay;  // what is kept of a weight: 1 - learning rate * weight decay
};

// What a network in training does with each of its numbers, on the calling thread.
struct Kernels {
  decltype(&gemm) multiply;
  // y = activation(y + bias) + skip for columns of `rows` numbers; slope becomes the activation's derivative there.
  // skip and slope may be null.
  void (*activate)(Activation activation, std::size_t rows, std::size_t columns, const float* bias, const float* skip,
                   float* y, float* slope);
  // The way back: up, where not null, becomes a copy of down; then down *= slope, and bias += the sum of its columns.
  void (*backward)(std::size_t rows, std::size_t columns, const float* slope, float* down, float* up, float* bias);
  // Adam with decoupled decay on `count` numbers from `first`, with the gradients of the pieces of a batch added in
  // their order.
  void (*adam)(const AdamStep& step, std::size_t first, std::size_t count, const float* const* gradients,
               std::size_t microbatches, float* parameters, float* mean, float* square);
  // One row of weights as the archive rounds it: to whole multiples of max|row| / levels.
  void (*round_row)(std::size_t count, float levels, const float* row, float* rounded);
};

// Compiled for the widest vectors the processor has: same bits on the same kind of processor.
const Kernels& kernels();

}  // namespace fb::bake
