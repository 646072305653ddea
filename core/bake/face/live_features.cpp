#include "bake/face/live_features.h"

#include <utility>

namespace fb::bake {

void keep_live_features(Network& network) {
  std::vector<Feature>& features = network.features;
  std::vector<char> used(features.size());
  const auto mark = [&](const std::vector<std::uint32_t>& list) {
    for (const std::uint32_t f : list) used[f] = 1;
  };
  mark(network.direct);
  for (const Region& region : network.regions) {
    mark(region.features);
    mark(region.gate.features);
  }
  // Features come after those they are made of.
  for (std::size_t f = features.size(); f-- > 0;)
    if (used[f] && features[f].of_features()) used[features[f].first] = used[features[f].second] = 1;

  std::vector<std::uint32_t> place(features.size());
  std::vector<Feature> kept;
  for (std::size_t f = 0; f < features.size(); ++f) {
    place[f] = static_cast<std::uint32_t>(kept.size());
    if (!used[f]) continue;
    Feature feature = features[f];
    if (feature.of_features()) {
      feature.first = place[feature.first];
      feature.second = place[feature.second];
    }
    kept.push_back(feature);
  }
  features = std::move(kept);
  const auto move = [&](std::vector<std::uint32_t>& list) {
    for (std::uint32_t& f : list) f = place[f];
  };
  move(network.direct);
  for (Region& region : network.regions) {
    move(region.features);
    move(region.gate.features);
  }
}

}  // namespace fb::bake
