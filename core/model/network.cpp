#include "model/network.h"

#include "base/checked.h"
#include "model/network_check.h"

namespace fb {
namespace {

void check_values(const DenseLayer& layer, const LayerPlace& place) {
  if (layer.weights.size() != checked_multiply(layer.inputs, layer.outputs, place.region) ||
      layer.bias.size() != layer.outputs)
    fail(Status::bad_data, "%s is %u x %u and has %zu weights, %zu biases", place.text().c_str(), layer.outputs,
         layer.inputs, layer.weights.size(), layer.bias.size());
  if (!all_finite(layer.weights) || !all_finite(layer.bias))
    fail(Status::not_finite, "%s holds a weight that is not finite", place.text().c_str());
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

void check_features(const std::vector<Feature>& features, std::size_t control_count) {
  for (std::size_t f = 0; f < features.size(); ++f) {
    const Feature& feature = features[f];
    if (feature.kind > Feature::Kind::minimum)
      fail(Status::unsupported, "feature %zu has unknown kind %u", f, static_cast<unsigned>(feature.kind));
    if (feature.of_features()) {
      const std::uint32_t later = std::max(feature.first, feature.second);
      if (later >= f)
        fail(Status::bad_data, "feature %zu is made of feature %u, which does not come before it", f, later);
      continue;
    }
    if (feature.control >= control_count)
      fail(Status::bad_data, "feature %zu names control %u of %zu", f, feature.control, control_count);
    if (!std::isfinite(feature.scale) || !std::isfinite(feature.threshold) || !(feature.threshold >= 0) ||
        !std::isfinite(feature.fall) || !(feature.fall >= 0))
      fail(Status::not_finite, "feature %zu has scale %g, threshold %g, fall %g", f, feature.scale, feature.threshold,
           feature.fall);
  }
}

void check_direct(const std::vector<std::uint32_t>& direct, const std::vector<Feature>& features) {
  for (const std::uint32_t f : direct)
    if (f >= features.size())
      fail(Status::bad_data, "a direct coefficient names feature %u of %zu", f, features.size());
}

void check_gate(const Gate& gate, const std::vector<Feature>& features, const char* region) {
  if (!std::isfinite(gate.slope) || !(gate.slope > 0))
    fail(Status::not_finite, "region \"%s\" has a gate of slope %g", region, gate.slope);
  const Feature* previous = nullptr;
  for (const std::uint32_t f : gate.features) {
    if (f >= features.size())
      fail(Status::bad_data, "the gate of region \"%s\" names feature %u of %zu", region, f, features.size());
    if (features[f].kind != Feature::Kind::identity)
      fail(Status::bad_data, "the gate of region \"%s\" names feature %u, which is not an identity", region, f);
    if (previous && features[f].control <= previous->control)
      fail(Status::bad_data, "the gate of region \"%s\" lists control %u after control %u", region, features[f].control,
           previous->control);
    previous = &features[f];
  }
}

void check(const Network& network, std::size_t control_count) {
  check_features(network.features, control_count);
  check_direct(network.direct, network.features);
  check_regions(network.regions, network.features, check_values);
}

}  // namespace fb
