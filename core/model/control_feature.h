// What a feature of one control is worth: one definition for baking, for readers and, side by side, for the kernels,
// which include nothing else of it.
#pragma once

#include <cstdint>

namespace fb {

enum class FeatureKind : std::uint32_t {
  identity = 0,  // u
  ramp = 1,      // max(u - threshold, 0); a negative scale makes the ramp of the other side
  hat = 2,       // max(min(t, 1 + (1 - t) * fall), 0), t = u - threshold: 0 up to one knot of a curve, 1 at the next,
                 // and 0 again from the one after; with fall 0 it stays 1: the last knot of a range
  product = 3,   // of two features
  minimum = 4,   // of two features
};

// FORMAT.md, "Features": `moved` is the control minus its value at rest, u that times the scale. max(a, 0) is 0 where a
// is not a number.
[[gnu::always_inline]] inline float control_feature(FeatureKind kind, float scale, float threshold, float fall,
                                                    float moved) {
  const float u = moved != 0 ? moved * scale : 0;
  const float t = u - threshold;
  const float falling = 1.0f + (1.0f - t) * fall;
  const float value = (kind != FeatureKind::hat) | (t < falling) ? t : falling;
  const float positive = value > 0 ? value : 0;
  return kind == FeatureKind::identity ? u : positive;
}

}  // namespace fb
