// Layers of float networks in Eigen, which the runtime is compared with.
#pragma once

#include <cstddef>

namespace fb::tool {

struct AffineKernels {
  const char* name;  // of the instruction set Eigen was compiled for
  // y = weights x + bias for `poses` columns; weights are outputs x inputs, column-major. bias may be null.
  void (*multiply)(std::size_t outputs, std::size_t inputs, std::size_t poses, const float* weights, const float* bias,
                   const float* x, float* y);
  // y = max(y, 0), plus x where it is not null.
  void (*rectify)(std::size_t count, const float* x, float* y);
  // y = y / (1 + exp(-y)), plus x where it is not null.
  void (*silu)(std::size_t count, const float* x, float* y);
};

// Those for the widest vectors of this processor.
const AffineKernels& affine_kernels();

}  // namespace fb::tool
