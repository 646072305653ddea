// What features are worth in a pose: one definition for the archive's readers and for baking.
#pragma once

#include <span>

#include "model/network.h"

namespace fb {

// Writes the value of every feature, in order. `controls` are within their ranges, `rest` are their rest values.
// max(a, 0) is 0 where a is not a number, as FORMAT.md says.
inline void feature_values(std::span<const Feature> features, const float* controls, const float* rest, float* values) {
  for (std::size_t f = 0; f < features.size(); ++f) {
    const Feature& feature = features[f];
    if (feature.of_features()) {
      const float a = values[feature.first], b = values[feature.second];
      values[f] = feature.kind == Feature::Kind::product ? a * b : a < b ? a : b;
      continue;
    }
    const float u = (controls[feature.control] - rest[feature.control]) * feature.scale;
    if (feature.kind == Feature::Kind::identity) {
      values[f] = u;
      continue;
    }
    float value = u - feature.threshold;
    if (feature.kind == Feature::Kind::hat) {
      const float falling = 1 + (1 - value) * feature.fall;
      value = value < falling ? value : falling;
    }
    values[f] = value > 0 ? value : 0;
  }
}

}  // namespace fb
