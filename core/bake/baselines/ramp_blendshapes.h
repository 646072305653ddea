// What single controls do at their limits: the start of every earlier system.
#pragma once

#include <vector>

#include "bake/recipe/recipe.h"

namespace fb::bake {

// One side of a control each: a ramp that is 0 at rest and 1 at the limit.
std::vector<Feature> ramp_features(const RigSchema& schema);

// What each ramp moves at its limit: ramps x 3 x vertices. A live rig is evaluated there. Among recorded poses the one
// in which a ramp is furthest along alone gives its shape; the shapes of ramps that are never alone are fitted to what
// the others leave, by regularised least squares over evenly spaced poses.
std::vector<float> ramp_shapes(const PoseSet& poses, RigEvaluator* rig, const std::vector<Feature>& ramps,
                               Progress& progress);

// Sets what moves a vertex less than this part of the diagonal along an axis to 0.
void drop_below(std::vector<float>& shapes, const Mesh& rest, double share);

}  // namespace fb::bake
