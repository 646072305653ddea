// A polygon mesh as it is drawn and exported, borrowed from whoever owns its arrays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/surface.h"

namespace fb::tool {

struct MeshView {
  std::span<const float> points;                   // 3 x vertices, at rest
  std::span<const std::uint32_t> polygon_sizes;    // corners of each polygon, at least 3
  std::span<const std::uint32_t> polygon_corners;  // vertex indices, polygon after polygon
  std::span<const float> uvs = {};                 // u and v of each texture coordinate; may be empty
  std::span<const std::uint32_t> uv_corners = {};  // index of a texture coordinate for each corner, if there are any

  std::size_t vertex_count() const { return points.size() / 3; }
  // Three vertex indices a triangle; polygons become fans around their first corner.
  std::vector<std::uint32_t> triangles() const { return triangle_fans(polygon_sizes, polygon_corners); }
  // Length of the diagonal of the bounding box.
  double diagonal() const { return box_diagonal(points); }
};

}  // namespace fb::tool
