#pragma once

#include <cstddef>
#include <filesystem>

#include "model/joints.h"

namespace fb::bake {

// The skin of a dataset: integers and floats of shape (vertices, influences). Fails naming the file on another shape,
// on numbers of joints that are below 0 or too large, and on more influences than a skin has.
Skin read_npy_skin(const std::filesystem::path& joints, const std::filesystem::path& weights, std::size_t vertices);
void write_npy_skin(const Skin& skin, const std::filesystem::path& joints, const std::filesystem::path& weights);

}  // namespace fb::bake
