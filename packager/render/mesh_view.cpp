#include "render/mesh_view.h"

#include <algorithm>
#include <cmath>

namespace fb::tool {

std::vector<std::uint32_t> MeshView::triangles() const {
  std::vector<std::uint32_t> corners;
  std::size_t first = 0;
  for (const std::uint32_t size : polygon_sizes) {
    for (std::uint32_t k = 1; k + 1 < size; ++k)
      corners.insert(corners.end(),
                     {polygon_corners[first], polygon_corners[first + k], polygon_corners[first + k + 1]});
    first += size;
  }
  return corners;
}

double MeshView::diagonal() const {
  double squared = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float low = INFINITY, high = -INFINITY;
    for (std::size_t i = axis; i < points.size(); i += 3) {
      low = std::min(low, points[i]);
      high = std::max(high, points[i]);
    }
    if (high > low) squared += (double(high) - low) * (double(high) - low);
  }
  return std::sqrt(squared);
}

}  // namespace fb::tool
