#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "bake/rig/gltf/gltf_options.h"
#include "bake/rig/source.h"

namespace fb::bake {

// Opens a .glb, .gltf or .vrm as a live, thread-safe rig in metres, y up: a character of all meshes that its scene
// shows. Vertices: those of the meshes in the order of nodes, see GltfMesh, placed by the nodes' transforms, or before
// skinning, see GltfJoints, whose joints and skin are the character's. Controls: the morph targets and the expressions
// of avatars, see GltfControls; from 0 to 1, resting at the default weights; widened, with a note, where a weight of
// the file lies beyond. Where joints are controls, see JointControls, these follow, vertices are as the file shows
// them, after skinning, and the character has neither joints nor skin. Clips: the animations, as training shots, see
// read_gltf_clips. Materials and images: those that the meshes use. Buffers and images may be files in the folder of
// the file, or below it. version() is a hash of what decides the points of a pose. Fails by name where there is nothing
// that could be a control, and on what GltfFile refuses. What is left out is in the notes.
OpenedSource open_gltf_rig(const std::string& path, const GltfOptions& options = {});
// The same of bytes in memory; other files are not read. `name`: of the character, where the file does not say.
OpenedSource open_gltf_rig(std::span<const std::byte> bytes, const std::string& name, const GltfOptions& options = {});

}  // namespace fb::bake
