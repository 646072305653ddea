#pragma once

#include <vector>

#include "bake/rig/gltf/gltf_controls.h"
#include "bake/rig/gltf/joint_controls.h"
#include "bake/rig/source.h"

namespace fb::bake {

// The animations as clips of 30 frames a second, one for each animation that moves weights or one of `moved`; tracks of
// several meshes are merged. A frame has the controls, then moved_columns of each of `moved`. Everything else that
// animations move is left out. Fails, naming the animation, on keys that are not whole, whose times do not increase, or
// that are not finite.
std::vector<Clip> read_gltf_clips(const GltfFile& file, const std::vector<ShownMesh>& shown,
                                  const GltfControls& controls, const std::vector<MovedNode>& moved, LeftOut& left_out);

}  // namespace fb::bake
