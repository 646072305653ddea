// What both earlier systems have in common: a skeleton found in the poses, and a basis whose columns are its bones.
#pragma once

#include <vector>

#include "bake/baselines/skinning/skeleton.h"
#include "model/basis.h"

namespace fb::bake {

// A basis of these dense columns (columns x 3 x vertices), with vertices in an order that keeps those of one bone
// together, so that few columns move a group of rows.
Basis basis_by_bone(const Skeleton& skeleton, const std::vector<float>& columns);

}  // namespace fb::bake
