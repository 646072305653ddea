#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/surface.h"

namespace fb {

// A polygon mesh as the source gave it: vertices are never merged, dropped or reordered; polygons keep their order and
// their first corner. Isolated, duplicate and non-manifold vertices are allowed.
struct Mesh {
  std::vector<float> points;                   // 3 x vertices, xyz interleaved
  std::vector<std::uint32_t> polygon_sizes;    // corners of each polygon, >= 3
  std::vector<std::uint32_t> polygon_corners;  // vertex indices, polygon after polygon
  // Texture coordinates, u and v interleaved, v pointing up from the lower edge of the image; and for each polygon
  // corner the index of its uv pair. A vertex on a seam has several. Both are empty without texture coordinates.
  std::vector<float> uvs = {};
  std::vector<std::uint32_t> uv_corners = {};

  std::size_t vertex_count() const { return points.size() / 3; }
  // Length of the diagonal of the bounding box of all vertices: the unit of reported errors.
  double diagonal() const { return box_diagonal(points); }
  // 3 vertex indices a triangle, in polygon order.
  std::vector<std::uint32_t> triangles() const { return triangle_fans(polygon_sizes, polygon_corners); }
};

// Fails, naming the vertex or polygon, on an empty mesh, a point that is not finite, a polygon of fewer than three
// corners, a corner index out of range, texture coordinates that are not finite or not one a corner, inconsistent
// counts, or a bounding box of zero size.
void check(const Mesh& mesh);

}  // namespace fb
