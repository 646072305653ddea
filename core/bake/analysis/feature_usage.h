#pragma once

#include <span>
#include <vector>

#include "model/network.h"
#include "model/rig_schema.h"

namespace fb::bake {

// How much and how often a feature is on over some poses.
struct FeatureUsage {
  double square = 0;  // mean square, over all poses
  double active = 0;  // share of the poses where it is not 0
};

// One for every feature; controls: poses x controls, rig values.
std::vector<FeatureUsage> feature_usage(const std::vector<Feature>& features, const RigSchema& schema,
                                        std::span<const float> controls);

}  // namespace fb::bake
