#include "runtime/quantized.h"

#include <algorithm>
#include <bit>
#include <cstdint>

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

Quantized quantize(const float* x, std::size_t count, float limit, std::span<ActiveColumn> active) {
  const float m = magnitude(x, count);
  if (m < smallest) return {};
  const float inverse = limit / m;
  std::size_t used = 0;
  for (std::size_t i = 0; i < count; ++i) {
    // Beyond 2^23 floats are whole, so adding 1.5 * 2^23 rounds to nearest even.
    float q = (x[i] * inverse + 12582912.0f) - 12582912.0f;
    q = q > limit ? limit : q < -limit ? -limit : q;
    // Written whether listed or not: whether an activation is 0 is a coin toss no branch predictor wins.
    active[used] = {static_cast<std::uint32_t>(i), q == q ? static_cast<std::int32_t>(q) : 0};
    used += active[used].input != 0;
  }
  return {active.first(used), m / limit};
}

}  // namespace fb
