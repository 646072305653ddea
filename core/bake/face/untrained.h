#pragma once

#include "bake/recipe/recipe.h"

namespace fb::bake {

// The recipe untrained: what analyse_rig measures of a live rig, as it is: activation curves with their in-betweens,
// correctives by finite differences, and the same for driven joints. No networks, and nothing is fitted to sampled
// poses, which only measure the face. Fails with invalid_argument on a recording.
RecipeResult make_untrained(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
