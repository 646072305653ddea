// What tinygltf takes for a fault in files that compress their geometry.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace fb::bake {

// The same file for the loader. Of buffers that only programs without meshopt compression need, which may have no data
// at all, one byte is left; and indices that Draco compresses, which lie in no buffer view, are said to lie in the
// first. Nothing where there is neither, or where the JSON is none.
std::optional<std::vector<std::byte>> loadable_file(std::span<const std::byte> bytes, bool binary);

}  // namespace fb::bake
