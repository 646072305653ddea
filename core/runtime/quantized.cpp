#include "runtime/quantized.h"

#include <algorithm>
#include <bit>

namespace fb {
namespace {

constexpr float smallest = 0x1p-100f, largest = 0x1p100f;

// The largest magnitude. Bits of positive floats have the order of the floats, and those of what is not a number come
// last; in whole numbers a maximum can be taken side by side.
float magnitude(const float* x, std::size_t count) {
  std::int32_t most = 0;
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, std::bit_cast<std::int32_t>(x[i]) & 0x7fffffff);
  return std::bit_cast<float>(std::min(most, std::bit_cast<std::int32_t>(largest)));
}

}  // namespace

void Quantized::quantize(const float* x, const std::uint32_t* places, std::size_t count, float limit) {
  step_ = 0;
  columns_ = {};
  const float m = magnitude(x, count);
  if (m < smallest) return;
  step_ = m / limit;
  const float inverse = limit / m;
  std::int32_t* wholes = wholes_.data();
  for (std::size_t i = 0; i < count; ++i) {
    // Beyond 2^23 floats are whole, so adding 1.5 * 2^23 rounds to nearest even.
    float q = (x[i] * inverse + 12582912.0f) - 12582912.0f;
    q = q > limit ? limit : q < -limit ? -limit : q;
    wholes[i] = static_cast<std::int32_t>(q == q ? q : 0);
  }
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
