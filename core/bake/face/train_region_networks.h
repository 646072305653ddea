#pragma once

#include <span>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "bake/face/face_recipe.h"
#include "bake/face/network_inputs.h"
#include "bake/sampling/validation_split.h"

namespace fb::bake {

struct RegionNetworks {
  std::size_t region_poses = 0;  // that were drawn for single regions
  std::vector<Region> regions;
  std::vector<RegionStats> stats;
  // The share of the squared residual that they leave, of validation poses, or of trained ones where there are none;
  // and what that is of the residual of all poses at a vertex, over D (rms).
  double share_left = 0, rms_error = 0;
};

// Trains one network a region on the coefficients of its basis, within the recipe's parameters and floating-point
// operations. A pilot training of narrow networks comes first: the error each leaves decides how many parameters its
// region gets, and how many poses of its own it is trained on besides: of a live rig without a budget, see
// region_poses. `rig`: null where there is none; `base`: the blendshapes whose residual is learnt.
RegionNetworks train_region_networks(const FaceRecipe& recipe, std::span<const FaceRegion> regions,
                                     std::span<const LocalBasis> bases, const RegionInputs& inputs,
                                     const TrainingPoses& training_poses, const SparseBlendshapes& base,
                                     RigEvaluator* rig, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
