// Blendshapes of single controls at their limits, from which every earlier system starts.
#pragma once

#include <vector>

#include "bake/recipe/recipe.h"

namespace fb::bake {

// One feature for each side of each control: a ramp from 0 at rest to 1 at the limit.
std::vector<Feature> ramp_features(const RigSchema& schema);

// The displacements of each ramp at its limit: ramps x 3 x vertices. Evaluates a live rig. In recorded poses, the shape
// is taken from the pose with the largest value of the ramp alone; ramps that are never alone are fitted to the
// residual of the others by regularised least squares over evenly spaced poses.
std::vector<float> ramp_shapes(const PoseSet& poses, RigEvaluator* rig, const std::vector<Feature>& ramps,
                               Progress& progress);

// Sets offsets along an axis below `threshold`, over the diagonal, to 0.
void drop_below(std::vector<float>& shapes, const Mesh& rest, double threshold);

}  // namespace fb::bake
