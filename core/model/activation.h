// Activation functions. They use only + - * / and comparisons, so they give the same bits on every machine; training
// and the runtime share these definitions.
#pragma once

#include <cstdint>

namespace fb {

// silu is x / (1 + exp(-x)).
enum class Activation : std::uint32_t { linear = 0, relu = 1, tanh = 2, silu = 3 };

// tanh with an absolute error of about 1e-6: a rational function of degree 13 over 6 on [-7.9, 7.9], constant outside.
// Coefficients: Eigen 3.4, Eigen/src/Core/MathFunctionsImpl.h (generic_fast_tanh_float).
[[gnu::always_inline]] inline float rational_tanh(float x) {
  constexpr float limit = 7.90531110763549805f;
  x = x < -limit ? -limit : x > limit ? limit : x;
  const float s = x * x;
  float p = s * -2.76076847742355e-16f + 2.00018790482477e-13f;
  p = s * p + -8.60467152213735e-11f;
  p = s * p + 5.12229709037114e-08f;
  p = s * p + 1.48572235717979e-05f;
  p = s * p + 6.37261928875436e-04f;
  p = s * p + 4.89352455891786e-03f;
  float q = s * 1.19825839466702e-06f + 1.18534705686654e-04f;
  q = s * q + 2.26843463243900e-03f;
  q = s * q + 4.89352518554385e-03f;
  return x * p / q;
}

// x / (1 + exp(-x)) = x * (1 + tanh(x / 2)) / 2.
[[gnu::always_inline]] inline float rational_silu(float x) {
  return x * (0.5f + 0.5f * rational_tanh(0.5f * x));
}

}  // namespace fb
