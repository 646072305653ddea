#pragma once

#include <filesystem>

#include "model/mesh.h"

namespace fb {

// The rest mesh of a dataset from a mesh file, .obj or .glb. Vertices keep the file's order: they must be those of the
// recorded points. Fails naming the file, and the line of an .obj.
Mesh read_mesh(const std::filesystem::path& path);

// Wavefront: "v" and "f" lines (positive or negative indices, texture and normal indices ignored); others are skipped.
Mesh read_obj(const std::filesystem::path& path);

// glTF binary: the one mesh in it, its primitives (triangles) one after the other.
Mesh read_glb(const std::filesystem::path& path);

// The two arrays of a dataset: points [V,3], faces [F,n] whose unused corners are -1.
Mesh read_npy_mesh(const std::filesystem::path& points, const std::filesystem::path& faces);
void write_npy_mesh(const Mesh& mesh, const std::filesystem::path& points, const std::filesystem::path& faces);

}  // namespace fb
