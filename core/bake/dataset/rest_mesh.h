#pragma once

#include <filesystem>
#include <string>

#include "model/mesh.h"

namespace fb::bake {

// The rest mesh of a dataset from a mesh file, .obj or .glb. Vertices keep the file's order: they must be those of the
// recorded points. Fails naming the file, and the line of an .obj.
Mesh read_mesh(const std::filesystem::path& path);

// Wavefront: "v", "vt" and "f" lines (positive or negative indices, those of normals ignored); others are skipped.
// Texture coordinates are left out unless every corner has them.
Mesh read_obj(const std::filesystem::path& path);

// glTF binary: the one mesh in it, see GltfMesh::surface.
Mesh read_glb(const std::filesystem::path& path);

// The files of a dataset's arrays: points [V,3], faces [F,n] whose unused corners are -1; and texture coordinates [U,2]
// with those of each corner, shaped like faces, or no names for no texture coordinates. In dataset.json they are the
// fields of "rest": { "points", "faces", "uvs", "uv_faces" }.
struct MeshArrays {
  std::string points, faces, uvs, uv_faces;
};
Mesh read_npy_mesh(const std::filesystem::path& folder, const MeshArrays& files);
void write_npy_mesh(const Mesh& mesh, const std::filesystem::path& folder, const MeshArrays& files);

}  // namespace fb::bake
