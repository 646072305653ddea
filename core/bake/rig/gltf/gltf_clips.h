#pragma once

#include <vector>

#include "bake/rig/gltf/gltf_controls.h"
#include "bake/rig/source.h"

namespace fb::bake {

// The animations of weights as clips of 30 frames a second, one for each animation; tracks of several meshes are
// merged. Everything else that animations move is left out. Fails, naming the animation, on keys that are not whole,
// whose times do not increase, or that are not finite.
std::vector<Clip> read_gltf_clips(const GltfFile& file, const std::vector<ShownMesh>& shown,
                                  const GltfControls& controls, LeftOut& left_out);

}  // namespace fb::bake
