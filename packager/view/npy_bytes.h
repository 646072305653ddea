#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace fb::tool {

// The bytes of a NumPy file (.npy, version 1) of float32 values in C order; as many as the shape says. The header comes
// before the values.
std::string npy_header(const std::vector<std::size_t>& shape);
std::string npy_bytes(std::span<const float> values, const std::vector<std::size_t>& shape);

}  // namespace fb::tool
