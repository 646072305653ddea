#pragma once

#include <span>
#include <vector>

#include "bake/face/face_recipe.h"
#include "bake/face/network_inputs.h"

namespace fb::bake {

struct Networks {
  std::vector<Region> regions;
  std::vector<RegionStats> stats;
  double rms = 0;  // of a vertex on poses kept back, over D
};

// Trains one network a region on the coefficients of its basis, within the recipe's numbers and operations. A short
// training of narrow networks comes first: it tells how much each region will leave, and so what each gets.
Networks train_networks(const FaceRecipe& recipe, std::span<const FaceRegion> regions,
                        std::span<const LocalBasis> bases, const RegionInputs& inputs, const PoseSet& poses,
                        const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
