// Feature values of a pose: one definition for the runtime, archive readers and baking.
#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "model/network.h"

namespace fb {

// One number of four poses, and the result of a comparison: all bits set or none.
using FourFloats = float __attribute__((vector_size(16)));
using FourMasks = std::int32_t __attribute__((vector_size(16)));

// condition ? value : +0, without a branch: which features of a pose are 0 is unpredictable.
inline float zero_unless(bool condition, float value) {
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) & (0 - std::uint32_t(condition)));
}
inline FourFloats zero_unless(FourMasks condition, FourFloats value) {
  return std::bit_cast<FourFloats>(std::bit_cast<FourMasks>(value) & condition);
}

// condition ? a : b, without a branch.
inline float select(bool condition, float a, float b) {
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(zero_unless(condition, a)) |
                              std::bit_cast<std::uint32_t>(zero_unless(!condition, b)));
}
inline FourFloats select(FourMasks condition, FourFloats a, FourFloats b) {
  return std::bit_cast<FourFloats>((std::bit_cast<FourMasks>(a) & condition) |
                                   (std::bit_cast<FourMasks>(b) & ~condition));
}
inline FourFloats select(bool condition, FourFloats a, FourFloats b) {
  const std::int32_t mask = -std::int32_t(condition);
  return select(FourMasks{mask, mask, mask, mask}, a, b);
}

inline float control_feature(const Feature& feature, float control, float rest) {
  return control_feature(feature.kind, feature.scale, feature.threshold, feature.fall, control - rest);
}

// The product or minimum of two feature values, of one pose (float) or of four (FourFloats).
template <class Number>
Number combined_feature(Feature::Kind kind, Number first, Number second) {
  const Number product = zero_unless((first != 0.0f) & (second != 0.0f), first * second);
  return select(kind == Feature::Kind::minimum, select(first < second, first, second), product);
}

// Writes the value of every feature, in order. `controls`: values within their ranges; `rest`: their rest values.
inline void feature_values(std::span<const Feature> features, const float* controls, const float* rest, float* values) {
  for (std::size_t f = 0; f < features.size(); ++f) {
    const Feature& feature = features[f];
    values[f] = feature.of_features() ? combined_feature(feature.kind, values[feature.first], values[feature.second])
                                      : control_feature(feature, controls[feature.control], rest[feature.control]);
  }
}

}  // namespace fb
