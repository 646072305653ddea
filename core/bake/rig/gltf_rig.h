#pragma once

#include <memory>
#include <string>

#include "bake/rig/source.h"

namespace fb::bake {

// Opens a .glb or .gltf as a live, thread-safe rig in metres, y up: the one mesh with morph targets in it.
// Vertices: those of its primitives in order, where its node and the nodes above it put them at rest.
// Controls: its morph targets in order, named by mesh.extras.targetNames, else "target0"...; from 0 to 1, resting at
// the default weights; widened, with a note, where a weight of the file lies beyond. Clips: every animation of its
// weights, LINEAR or STEP, as a training shot at 30 frames a second. Fails by name on no such mesh or several, a skin,
// and what GltfFile refuses. What is left out is in the notes.
std::unique_ptr<Source> open_gltf_rig(const std::string& path);

}  // namespace fb::bake
