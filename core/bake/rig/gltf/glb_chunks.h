// The JSON of a glTF file, text or binary.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace fb::bake {

// All of a text file, or the first chunk of a binary one, as far as it is there.
std::string_view json_of_gltf(std::span<const std::byte> bytes, bool binary);

// The same file with another JSON; chunks behind it stay as they are.
std::vector<std::byte> with_json(std::span<const std::byte> bytes, bool binary, std::string json);

}  // namespace fb::bake
