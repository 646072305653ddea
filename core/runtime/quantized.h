// Floats become whole numbers of one step, so that what is made of them is exact.
#pragma once

#include <cstddef>
#include <span>

#include "runtime/kernels/panel_sums.h"

namespace fb {

// x[i] is about step * input, where place i is listed, and about 0 where it is not. step is 0 if all are.
struct Quantized {
  std::span<const ActiveColumn> active;
  float step = 0;
};

// FORMAT.md, "Whole numbers". `active` is working memory of at least `count` entries; `limit` is the largest input.
Quantized quantize(const float* x, std::size_t count, float limit, std::span<ActiveColumn> active);

}  // namespace fb
