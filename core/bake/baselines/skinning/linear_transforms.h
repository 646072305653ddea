#pragma once

#include <span>
#include <vector>

#include "bake/baselines/skinning/skeleton.h"

namespace fb::bake {

// Transforms of all bones that come closest to shapes (shapes x 3 x vertices) by least squares: any matrices [A t], so
// that those of several shapes add up. Of all pairs of a shape and a bone a share is kept, those that move vertices
// most: the least are dropped by halves, and the others fitted again. Returns shapes x parameter_count() floats.
std::vector<float> fit_linear_transforms(const Skeleton& skeleton, const Mesh& rest, std::span<const float> shapes,
                                         double share, const Parallel& parallel);

}  // namespace fb::bake
