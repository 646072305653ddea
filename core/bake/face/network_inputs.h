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

// A control as a feature: its distance from rest, in units of its reach.
Feature identity_feature(const RigSchema& schema, std::uint32_t control);

// One identity feature a control, in the order of the controls.
std::vector<Feature> identity_features(const RigSchema& schema);

// The values of identity_features in poses (poses x controls): poses x controls.
std::vector<float> identity_values(std::vector<float> controls, const RigSchema& schema);

// The features of a face, and which of them are the inputs of each region's network.
struct RegionInputs {
  std::vector<Feature> features;  // those of the blendshapes, then identities of the controls that regions need
  std::vector<std::vector<std::uint32_t>> of_region;  // feature indices, ascending
  std::vector<Gate> gates;                            // one a region
  std::vector<std::vector<float>> scales;             // of the features of each region, see input_scales
};

// How strongly each feature of a region's network is expected to act, see TrainingSet: the motion of its control, of
// several the least, to a power, with a mean square of 1. On a production rig of 303 controls, of which single ones
// move the residual of a region from 1e-4 to 1e-2 of the diagonal, scales lowered the mse from 3,000 recorded poses
// from 7.1e-7 to 5.2e-7, from 9,000 from 2.2e-7 to 1.4e-7; inputs of more than 1e-3 alone reached 5.9e-7 and 2.6e-7.
std::vector<float> input_scales(std::span<const Feature> features, std::span<const std::uint32_t> of_region,
                                const FaceRegion& region);

// A region's inputs are its controls and the strongest product and minimum features of their correctives, about as many
// as it has controls, besides all steps of its controls. With `gated`, its gate has its controls as features: its
// coefficients are 0 while at most one control is active, which keeps single controls as exact as the blendshapes.
RegionInputs region_inputs(const RigAnalysis& analysis, const RigSchema& schema, std::span<const FaceRegion> regions,
                           bool gated);

// The values of the networks' input features in every pose.
struct FeatureTable {
  std::size_t poses = 0;
  std::vector<std::uint32_t> features;    // feature indices, ascending: the columns
  std::vector<float> values;              // poses x features
  std::vector<std::vector<float>> gates;  // the gate value of each region in every pose; empty without a gate

  // The columns of these features.
  std::vector<std::uint32_t> columns(std::span<const std::uint32_t> of) const;
};

// controls: poses x controls of the schema.
FeatureTable feature_table(const RegionInputs& inputs, const RigSchema& schema, std::span<const float> controls,
                           const Parallel& parallel);

// Removes the features that no coefficient, input, gate or other feature uses; the others keep their order.
void keep_live_features(Network& network);

}  // namespace fb::bake
