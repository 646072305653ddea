#pragma once

#include <vector>

#include "bake/rig/gltf/gltf_controls.h"
#include "bake/rig/gltf/joint_controls.h"
#include "bake/rig/source.h"

namespace fb::bake {

// The animations as clips at the rates of their keys, see rate_of, one for each animation that moves weights or one of
// `moved`; tracks of several meshes are merged. A frame has the controls, then moved_columns of each of `moved`.
// Everything else that animations move is left out. Fails, naming the animation, on keys that are not whole, whose
// times decrease, or that are not finite; with `skip_broken` such an animation is left out.
std::vector<Clip> read_gltf_clips(const GltfFile& file, const std::vector<ShownMesh>& shown,
                                  const GltfControls& controls, const std::vector<MovedNode>& moved, bool skip_broken,
                                  LeftOut& left_out);

}  // namespace fb::bake
