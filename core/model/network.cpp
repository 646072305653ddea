#include "model/network.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"
#include "base/status.h"

namespace fb {
namespace {

bool finite(const std::vector<float>& values) {
  return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

void check(const DenseLayer& layer, std::size_t inputs, const char* where) {
  if (layer.inputs != inputs)
    fail(Status::bad_data, "%s takes %u inputs and is given %zu", where, layer.inputs, inputs);
  if (layer.outputs == 0) fail(Status::bad_data, "%s has no outputs", where);
  if (layer.weights.size() != checked_multiply(layer.inputs, layer.outputs, where) ||
      layer.bias.size() != layer.outputs)
    fail(Status::bad_data, "%s is %u x %u and has %zu weights, %zu biases", where, layer.outputs, layer.inputs,
         layer.weights.size(), layer.bias.size());
  if (layer.skip && layer.inputs != layer.outputs)
    fail(Status::bad_data, "%s skips from %u inputs to %u outputs", where, layer.inputs, layer.outputs);
  if (layer.activation > Activation::relu)
    fail(Status::unsupported, "%s has unknown activation %u", where, static_cast<unsigned>(layer.activation));
  if (!finite(layer.weights) || !finite(layer.bias))
    fail(Status::not_finite, "%s holds a weight that is not finite", where);
}

}  // namespace

std::size_t Network::coefficient_count() const {
  std::size_t count = direct.size();
  for (const Region& region : regions)
    if (!region.layers.empty()) count += region.layers.back().outputs;
  return count;
}

std::size_t Network::parameter_count() const {
  std::size_t count = 0;
  for (const Region& region : regions)
    for (const DenseLayer& layer : region.layers) count += layer.weights.size() + layer.bias.size();
  return count;
}

void check(const Network& network, std::size_t control_count) {
  for (std::size_t f = 0; f < network.features.size(); ++f) {
    const Feature& feature = network.features[f];
    if (feature.kind > Feature::Kind::ramp)
      fail(Status::unsupported, "feature %zu has unknown kind %u", f, static_cast<unsigned>(feature.kind));
    if (feature.control >= control_count)
      fail(Status::bad_data, "feature %zu names control %u of %zu", f, feature.control, control_count);
    if (!std::isfinite(feature.scale) || !std::isfinite(feature.threshold) || feature.threshold < 0)
      fail(Status::not_finite, "feature %zu has scale %g, threshold %g", f, feature.scale, feature.threshold);
  }
  for (const std::uint32_t f : network.direct)
    if (f >= network.features.size())
      fail(Status::bad_data, "a direct coefficient names feature %u of %zu", f, network.features.size());
  for (const Region& region : network.regions) {
    for (const std::uint32_t f : region.features)
      if (f >= network.features.size())
        fail(Status::bad_data, "region \"%s\" names feature %u of %zu", region.name.c_str(), f,
             network.features.size());
    if (region.layers.empty()) fail(Status::bad_data, "region \"%s\" has no layers", region.name.c_str());
    std::size_t width = region.features.size();
    for (std::size_t l = 0; l < region.layers.size(); ++l) {
      check(region.layers[l], width, format("region \"%s\" layer %zu", region.name.c_str(), l).c_str());
      width = region.layers[l].outputs;
    }
  }
}

}  // namespace fb
