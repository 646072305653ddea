// The polygons of a square sheet, for tests of what depends on neighbouring vertices.
#pragma once

#include <cstdint>

#include "model/mesh.h"

namespace fb {

// Adds the quads of a grid of side x side vertices, row after row from vertex `first` on, facing up or down.
inline void add_grid_quads(Mesh& mesh, std::uint32_t side, std::uint32_t first = 0, bool up = true) {
  for (std::uint32_t y = 0; y + 1 < side; ++y)
    for (std::uint32_t x = 0; x + 1 < side; ++x) {
      const std::uint32_t a = first + y * side + x, b = a + 1, c = a + side + 1, d = a + side;
      mesh.polygon_sizes.push_back(4);
      for (const std::uint32_t corner : {a, up ? b : d, c, up ? d : b}) mesh.polygon_corners.push_back(corner);
    }
}

}  // namespace fb
