#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fb::bake {

// The archive of a face whose positions were times 2^exponent (scaled_source.h), in the units of its source, with new
// reference poses by `seed`; licence and certificate stay.
std::vector<std::byte> in_units_of_source(std::span<const std::byte> archive, int exponent, std::uint64_t seed);

}  // namespace fb::bake
