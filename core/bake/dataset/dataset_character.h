#pragma once

#include <filesystem>

#include "bake/dataset/dataset_index.h"
#include "model/character.h"
#include "model/mesh.h"

namespace fb::bake {

// The rest mesh that an index names, with its parts. Fails naming the file.
Mesh read_rest_mesh(const std::filesystem::path& folder, const DatasetIndex& index);

// What an index says of the character, with the bytes of images, the frames of sockets at rest and the skin. Fails
// naming the file.
Character read_dataset_character(const std::filesystem::path& folder, const DatasetIndex& index, const Mesh& rest);

}  // namespace fb::bake
