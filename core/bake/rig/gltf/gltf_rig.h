#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "bake/rig/source.h"

namespace fb::bake {

// Opens a .glb or .gltf as a live, thread-safe rig in metres, y up: a character of all meshes that its scene shows.
// Vertices: those of the meshes in the order of nodes, see GltfMesh, placed by the nodes' transforms, or before
// skinning, see GltfJoints, whose joints and skin are the character's. Controls: the morph targets, see GltfControls;
// from 0 to 1, resting at the default weights; widened, with a note, where a weight of the file lies beyond. Clips: the
// animations of weights, as training shots, see read_gltf_clips. Materials and images: those that the meshes use.
// Buffers and images may be files in the folder of the file, or below it. version() is a hash of the vertices and the
// morph targets. Fails by name where no mesh has morph targets, and on what GltfFile refuses. What is left out is in
// the notes.
OpenedSource open_gltf_rig(const std::string& path);
// The same of bytes in memory; other files are not read. `name`: of the character, where the file does not say.
OpenedSource open_gltf_rig(std::span<const std::byte> bytes, const std::string& name);

}  // namespace fb::bake
