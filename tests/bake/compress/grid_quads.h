// The polygons of a square sheet, for tests of what depends on neighbouring vertices.
#pragma once

#include <cstdint>

#include "model/mesh.h"

namespace fb {

// Adds the quads of a grid of side x side vertices, row after row.
inline void add_grid_quads(Mesh& mesh, std::uint32_t side) {
  for (std::uint32_t y = 0; y + 1 < side; ++y)
    for (std::uint32_t x = 0; x + 1 < side; ++x) {
      const std::uint32_t v = y * side + x;
      mesh.polygon_sizes.push_back(4);
      for (const std::uint32_t corner : {v, v + 1, v + side + 1, v + side}) mesh.polygon_corners.push_back(corner);
    }
}

}  // namespace fb
