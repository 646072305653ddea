// Checks shared by Network (floats) and PackedModel (integers).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "base/status.h"
#include "model/network.h"

namespace fb {

// Fails, naming the feature, unless its control exists, products and minima use earlier features, and numbers are
// finite.
void check_features(const std::vector<Feature>& features, std::size_t control_count);

// Fails unless the features of direct coefficients exist.
void check_direct(const std::vector<std::uint32_t>& direct, const std::vector<Feature>& features);

// Fails unless the gate's features exist and are identities of ascending controls, and its slope is finite and
// positive.
void check_gate(const Gate& gate, const std::vector<Feature>& features, const char* region);

// A layer, for messages.
struct LayerPlace {
  const char* region;
  std::size_t number;
  std::string text() const { return format("region \"%s\" layer %zu", region, number); }
};

// Fails, naming region and layer, unless the widths of consecutive layers agree. check_values(layer, place) checks a
// layer's numbers.
template <class AnyRegion, class CheckValues>
void check_regions(const std::vector<AnyRegion>& regions, const std::vector<Feature>& features,
                   CheckValues&& check_values) {
  for (const AnyRegion& region : regions) {
    const char* name = region.name.c_str();
    for (const std::uint32_t f : region.features)
      if (f >= features.size())
        fail(Status::bad_data, "region \"%s\" names feature %u of %zu", name, f, features.size());
    if (region.layers.empty()) fail(Status::bad_data, "region \"%s\" has no layers", name);
    std::size_t width = region.features.size();
    for (std::size_t l = 0; l < region.layers.size(); ++l) {
      const auto& layer = region.layers[l];
      const LayerPlace place = {name, l};
      if (layer.inputs != width)
        fail(Status::bad_data, "%s takes %u inputs and is given %zu", place.text().c_str(), layer.inputs, width);
      if (layer.outputs == 0) fail(Status::bad_data, "%s has no outputs", place.text().c_str());
      if (layer.skip && layer.inputs != layer.outputs)
        fail(Status::bad_data, "%s skips from %u inputs to %u outputs", place.text().c_str(), layer.inputs,
             layer.outputs);
      if (layer.activation > Activation::silu)
        fail(Status::unsupported, "%s has unknown activation %u", place.text().c_str(),
             static_cast<unsigned>(layer.activation));
      check_values(layer, place);
      width = layer.outputs;
    }
    check_gate(region.gate, features, name);
  }
}

inline bool all_finite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

}  // namespace fb
