#include "runtime/quantized.h"

namespace fb {

void Quantized::quantize(const PoseKernels& kernels, float* x, const std::uint32_t* places, std::size_t count,
                         float limit) {
  std::int32_t* wholes = wholes_.data();
  columns_ = {};
  step_ = kernels.round_all(x, count, limit, wholes);
  if (step_ == 0) return;
  // Written whether listed or not: whether an activation is 0 is a coin toss no branch predictor wins.
  std::uint32_t *listed = places_.data(), sum = 0;
  std::int16_t* inputs = inputs_.data();
  std::size_t used = 0;
  for (std::size_t i = 0; i < count; ++i) {
    listed[used] = places ? places[i] : static_cast<std::uint32_t>(i);
    inputs[used] = static_cast<std::int16_t>(wholes[i]);
    sum += static_cast<std::uint32_t>(wholes[i]);
    used += wholes[i] != 0;
  }
  for (; used % 4 != 0; ++used) {
    listed[used] = listed[0];
    inputs[used] = 0;
  }
  columns_ = {listed, inputs, used, 0 - 128 * sum};
}

}  // namespace fb
