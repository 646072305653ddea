#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/analysis/rig_analysis.h"
#include "bake/regions/find_regions.h"
#include "bake/rig/pose_set.h"
#include "base/parallel.h"
#include "model/network.h"

namespace fb::bake {

// The features of a face and which of them each region's network is given.
struct RegionInputs {
  std::vector<Feature> features;  // those of the base, then an identity for each control that a region needs
  std::vector<std::vector<std::uint32_t>> of_region;  // inputs, ascending
  std::vector<Gate> gates;                            // one a region
};

// A region's inputs are its controls and the strongest products and minima probed of them, about as many as it has
// controls; its gate, with `gated`, watches its controls.
RegionInputs region_inputs(const RigAnalysis& analysis, const RigSchema& schema, std::span<const FaceRegion> regions,
                           bool gated);

// The values that training needs of every pose.
struct FeatureTable {
  std::size_t poses = 0;
  std::vector<std::uint32_t> features;    // which, ascending
  std::vector<float> values;              // poses x features
  std::vector<std::vector<float>> gates;  // a region's gate in every pose; empty without one

  // Where these features are in a row.
  std::vector<std::uint32_t> columns(std::span<const std::uint32_t> of) const;
};

FeatureTable feature_table(const RegionInputs& inputs, const PoseSet& poses, const Parallel& parallel);

}  // namespace fb::bake
