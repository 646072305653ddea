// What features are worth in a pose: one definition for the archive's readers and for baking.
#pragma once

#include <span>

#include "model/network.h"

namespace fb {

// FORMAT.md, "Features". max(a, 0) is 0 where a is not a number.
inline float control_feature(const Feature& feature, float control, float rest) {
  const float u = control == rest ? 0 : (control - rest) * feature.scale;
  if (feature.kind == Feature::Kind::identity) return u;
  float value = u - feature.threshold;
  if (feature.kind == Feature::Kind::hat) {
    const float falling = 1 + (1 - value) * feature.fall;
    value = value < falling ? value : falling;
  }
  return value > 0 ? value : 0;
}

// A product or minimum of features of these values.
inline float combined_feature(Feature::Kind kind, float first, float second) {
  if (kind == Feature::Kind::minimum) return first < second ? first : second;
  return first == 0 || second == 0 ? 0 : first * second;
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
