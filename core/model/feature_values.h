// What features are worth in a pose: one definition for the archive's readers and for baking.
#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "model/network.h"

namespace fb {

// Numbers of four poses side by side, and what comparing them gives: all bits or none.
using FourFloats = float __attribute__((vector_size(16)));
using FourMasks = std::int32_t __attribute__((vector_size(16)));

// `value` where `wanted`, else +0: without a branch, because which features of a pose are 0 cannot be predicted.
inline float zero_unless(bool wanted, float value) {
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) & (0 - std::uint32_t(wanted)));
}
inline FourFloats zero_unless(FourMasks wanted, FourFloats value) {
  return std::bit_cast<FourFloats>(std::bit_cast<FourMasks>(value) & wanted);
}

// `a` where `first`, else `b`, likewise.
inline float either(bool first, float a, float b) {
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(zero_unless(first, a)) |
                              std::bit_cast<std::uint32_t>(zero_unless(!first, b)));
}
inline FourFloats either(FourMasks first, FourFloats a, FourFloats b) {
  return std::bit_cast<FourFloats>((std::bit_cast<FourMasks>(a) & first) | (std::bit_cast<FourMasks>(b) & ~first));
}
inline FourFloats either(bool first, FourFloats a, FourFloats b) {
  const std::int32_t mask = -std::int32_t(first);
  return either(FourMasks{mask, mask, mask, mask}, a, b);
}

inline float control_feature(const Feature& feature, float control, float rest) {
  return control_feature(feature.kind, feature.scale, feature.threshold, feature.fall, control - rest);
}

// A product or minimum of features of these values, of one pose or of four.
template <class Number>
Number combined_feature(Feature::Kind kind, Number first, Number second) {
  const Number product = zero_unless((first != 0.0f) & (second != 0.0f), first * second);
  return either(kind == Feature::Kind::minimum, either(first < second, first, second), product);
}

// Writes the value of every feature, in order. `controls` are within their ranges, `rest` are their rest values.
inline void feature_values(std::span<const Feature> features, const float* controls, const float* rest, float* values) {
  for (std::size_t f = 0; f < features.size(); ++f) {
    const Feature& feature = features[f];
    values[f] = feature.of_features() ? combined_feature(feature.kind, values[feature.first], values[feature.second])
                                      : control_feature(feature, controls[feature.control], rest[feature.control]);
  }
}

}  // namespace fb
