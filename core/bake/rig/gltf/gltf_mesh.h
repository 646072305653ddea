#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bake/rig/gltf/gltf_file.h"
#include "bake/rig/gltf/left_out.h"
#include "model/mesh.h"

namespace tinygltf {
struct Mesh;
}  // namespace tinygltf

namespace fb::bake {

// Offsets of the vertices that one unit of a weight moves.
struct MorphTarget {
  std::vector<std::uint32_t> vertices;
  std::vector<float> offsets;  // xyz of each
};

// Joints of a skin that each vertex follows, and how much; weights may be 0.
struct VertexJoints {
  std::size_t per_vertex = 0;
  std::vector<std::uint32_t> joints;  // vertices x per_vertex
  std::vector<float> weights;         // of each
};

// A mesh of a glTF file, in its own coordinates: its primitives one after the other. Primitives that have all their
// vertices in common, as where a mesh is divided by material, share them.
struct GltfMesh {
  // Triangles. Texture coordinates are the first of the file, placed as common_placement of the material says; where
  // only some primitives have them, they are 0 in the others.
  Mesh surface;
  std::vector<MaterialRun> materials;  // one a primitive; `material`: index in the file
  std::vector<MorphTarget> targets;
  VertexJoints joints;
};

// The name, or "(unnamed)"; for messages.
const char* shown_name(const std::string& name);
// Morph targets of a mesh: those of the primitive that has most.
std::size_t target_count(const tinygltf::Mesh& mesh);

// The surface alone. Left out are points and lines, primitives without positions, and corners behind the last whole
// triangle. Fails on what is not whole or not finite.
Mesh read_gltf_surface(const GltfFile& file, const tinygltf::Mesh& mesh);
// With everything else that moves or colours it. Primitives that lack morph targets or joints which others have do not
// move by them. `joints`: joints of its skin; 0: it has none.
GltfMesh read_gltf_mesh(const GltfFile& file, const tinygltf::Mesh& mesh, std::size_t joints, LeftOut& left_out);

}  // namespace fb::bake
