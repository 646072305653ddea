#pragma once

#include "bake/baselines/skinning/bone_motion.h"

namespace fb::bake {

// At most `bones` clusters of vertices that move as rigidly as possible, as a skeleton with one bone a vertex. All
// bones have the centre of the mesh.
Skeleton cluster_bones(const Mesh& rest, const PoseSample& poses, std::uint32_t bones, const Parallel& parallel,
                       Progress& progress);

}  // namespace fb::bake
