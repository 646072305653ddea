#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "solve/mesh_correspondence.h"

namespace fb::tool {

// Correspondences that somebody else found, or that write_correspondence() wrote: rows of seven numbers, a vertex of
// the face, three vertices of the other mesh and their weights. .json: {"correspondences": [[...], ...]}; .npy: rows x
// 7 floats, as NumPy writes them. Distances are 0. Fails with bad_data, naming file and row, where a vertex is none, a
// weight is not from -1 to 2, weights do not sum to 1 within 0.001, or a vertex of the face has two rows; with
// invalid_argument for another extension.
std::vector<Correspondence> read_correspondence(const std::filesystem::path& path, std::size_t face_vertices,
                                                std::size_t other_vertices);

// Writes the vertices that have a partner as such a .json, complete or not at all.
void write_correspondence(const std::filesystem::path& path, std::span<const Correspondence> vertices);

}  // namespace fb::tool
