// Reads the subset of Draco's bitstream 2.2 that section "geometry" holds, as DRACO.md describes it: a triangle mesh
// coded by Edgebreaker with one attribute, the positions. Draco's library is not needed.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <vector>

#include "archive/container/byte_reader.h"

namespace fb::archive {

inline constexpr std::size_t draco_header_bytes = 12;          // before the number of points
inline constexpr std::int32_t max_grid_coordinate = 0xffffff;  // integers up to here are exact as floats

struct DracoMesh {
  std::pmr::vector<std::uint32_t> positions;  // 3 x points: the bits of integers or of floats
  std::pmr::vector<std::uint32_t> triangles;  // 3 points each
};

// Reads to the end of the section. The data must hold so many points and triangles, with positions that are integers
// within max_grid_coordinate, or floats. Untrusted: fails with `corrupt`, and with `limit` where memory is over budget.
DracoMesh read_draco(ByteReader& in, std::uint32_t points, std::uint32_t triangles, bool integers);

}  // namespace fb::archive
