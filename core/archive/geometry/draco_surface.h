// The connectivity of Draco data: faces as corners, three a face, decoded by Edgebreaker (J. Rossignac, "Edgebreaker:
// connectivity compression for triangle meshes", 1999; decoded from the last symbol to the first as in M. Isenburg and
// J. Snoeyink, "Spirale Reversi", 2001), as DRACO.md describes it.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <vector>

#include "archive/container/byte_reader.h"

namespace fb::archive {

inline constexpr std::uint32_t no_corner = 0xffffffff;

// Corner k of face f is number 3 f + k. A corner also names the edge of its face that does not touch it.
struct DracoSurface {
  std::pmr::vector<std::uint32_t> vertices;   // of each corner
  std::pmr::vector<std::uint32_t> opposites;  // the corner that names the same edge in the other face, or no_corner
  std::pmr::vector<bool> inside;              // for each vertex, whether no edge at it is on the boundary
};

inline std::uint32_t next_corner(std::uint32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}
inline std::uint32_t previous_corner(std::uint32_t corner) {
  return corner % 3 == 0 ? corner + 2 : corner - 1;
}

// Reads the connectivity of so many points and faces. Vertices are numbers below the size of `inside`, not all of
// which are of a corner. Untrusted: fails with `corrupt`, and with `limit` where memory is over budget.
DracoSurface read_draco_surface(ByteReader& in, std::uint32_t points, std::uint32_t faces);

}  // namespace fb::archive
