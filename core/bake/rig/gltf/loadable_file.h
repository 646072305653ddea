// What tinygltf takes for a fault in files that have extensions.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace fb::bake {

// The same file for the loader. Of buffers that only programs without meshopt compression need, which may have no data
// at all, one byte is left; indices that Draco compresses, which lie in no buffer view, are said to lie in the first;
// channels of animations that aim by a pointer, and at no node, are said to aim at the first; and URIs of buffers are
// encoded so that the loader, which takes a plus sign for a blank, asks for them as they were written. Nothing where
// there is none of these, or where the JSON is none.
std::optional<std::vector<std::byte>> loadable_file(std::span<const std::byte> bytes, bool binary);

}  // namespace fb::bake
