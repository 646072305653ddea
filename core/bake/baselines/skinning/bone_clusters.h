#pragma once

#include "bake/baselines/skinning/bone_motion.h"

namespace fb::bake {

// At most `bones` clusters of vertices, each moving as rigidly as can be, as a skeleton whose vertices hang on one bone
// each. All centres are the mesh's own.
Skeleton cluster_vertices(const Mesh& rest, const HoldoutSet& poses, std::uint32_t bones, const Parallel& parallel,
                          Progress& progress);

}  // namespace fb::bake
