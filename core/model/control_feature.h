// The value of a feature of one control: one definition for baking, archive readers and the vectorised kernels, which
// include no other header of the model.
#pragma once

#include <cstdint>

namespace fb {

enum class FeatureKind : std::uint32_t {
  identity = 0,  // u
  ramp = 1,      // max(u - threshold, 0); a negative scale gives the ramp on the other side of rest
  hat = 2,      // max(min(t, 1 + (1 - t) * fall), 0), t = u - threshold: a linear B-spline, 0 at one knot of a curve, 1
                // at the next and 0 at the one after; with fall 0 it stays 1: the last knot of a range
  product = 3,  // of two features
  minimum = 4,  // of two features
};

// EVALUATION.md, "Features". `offset`: the control minus its rest value; u = offset * scale. max(NaN, 0) is 0.
[[gnu::always_inline]] inline float control_feature(FeatureKind kind, float scale, float threshold, float fall,
                                                    float offset) {
  const float u = offset != 0 ? offset * scale : 0;
  const float t = u - threshold;
  const float falling = 1.0f + (1.0f - t) * fall;
  const bool rises = (kind != FeatureKind::hat) | (t < falling);
  const float value = rises ? t : falling;
  const float positive = value > 0 ? value : 0;
  return kind == FeatureKind::identity ? u : positive;
}

}  // namespace fb
