// What features are worth in a pose: one definition for the archive's readers and for baking.
#pragma once

#include <bit>
#include <cstdint>
#include <span>

#include "model/network.h"

namespace fb {

// `value` where `wanted`, else +0: without a branch, because which features of a pose are 0 cannot be predicted.
inline float zero_unless(bool wanted, float value) {
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) & (0 - std::uint32_t(wanted)));
}

// FORMAT.md, "Features". max(a, 0) is 0 where a is not a number.
inline float control_feature(const Feature& feature, float control, float rest) {
  const float u = zero_unless(control != rest, (control - rest) * feature.scale);
  if (feature.kind == Feature::Kind::identity) return u;
  float value = u - feature.threshold;
  if (feature.kind == Feature::Kind::hat) {
    const float falling = 1 + (1 - value) * feature.fall;
    value = value < falling ? value : falling;
  }
  return zero_unless(value > 0, value);
}

// A product or minimum of features of these values.
inline float combined_feature(Feature::Kind kind, float first, float second) {
  const bool minimum = kind == Feature::Kind::minimum;
  const float product = zero_unless((first != 0) & (second != 0), first * second);
  const float least = first < second ? first : second;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(zero_unless(minimum, least)) |
                              std::bit_cast<std::uint32_t>(zero_unless(!minimum, product)));
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
