// Levels of detail from what a bake is asked for.
#pragma once

#include "bake/levels/level_plan.h"
#include "bake/recipe/bake_options.h"
#include "base/progress.h"

namespace fb::bake {

// The levels that the options ask for, of given meshes or simplified with attention to motion: distances are those of
// mixed_points of up to 24 poses far from each other. Empty if they ask for none. Fails with invalid_argument unless
// the shares of vertices fall from below 1, and as matched_levels does.
LevelPlan plan_levels(const PoseSet& poses, const Character& character, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
