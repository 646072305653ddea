#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fb {

// A polygon mesh as the rig made it: vertices are never merged, dropped or reordered; polygons keep their order and
// their first corner. Isolated, duplicate and non-manifold vertices are allowed.
struct Mesh {
  std::vector<float> points;                   // 3 x vertices, xyz interleaved
  std::vector<std::uint32_t> polygon_sizes;    // corners of each polygon, >= 3
  std::vector<std::uint32_t> polygon_corners;  // vertex indices, polygon after polygon
  // Texture coordinates, u and v interleaved, v growing upwards from the lower edge of the picture; and the index of
  // the pair that each polygon corner has. A vertex on a seam has several. Without texture coordinates both are empty.
  std::vector<float> uvs = {};
  std::vector<std::uint32_t> uv_corners = {};

  std::size_t vertex_count() const { return points.size() / 3; }
  // Length of the diagonal of the bounding box of all vertices: the unit of every reported error.
  double diagonal() const;
  // Fans from each polygon's first corner: 3 indices a triangle, in polygon order.
  std::vector<std::uint32_t> triangles() const;
};

// Fails, naming the vertex or polygon, on no vertices, a point that is not finite, a polygon under three corners, a
// corner that is no vertex, texture coordinates that are not finite or not one a corner, counts that disagree, or a
// bounding box without size.
void check(const Mesh& mesh);

}  // namespace fb
