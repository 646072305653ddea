// Size, triangles and normals of a mesh, and nearest points of triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/vector3.h"

namespace fb {

// Length of the diagonal of the bounding box of `points` (3 x vertices); 0 without any.
double box_diagonal(std::span<const float> points);

// Three vertex indices a triangle, in polygon order; polygons become fans around their first corner. sizes: corners of
// each polygon, >= 3; corners: vertex indices, polygon after polygon.
std::vector<std::uint32_t> triangle_fans(std::span<const std::uint32_t> sizes, std::span<const std::uint32_t> corners);

// Unit vertex normals, averaged over the adjacent triangles weighted by their area; null for a vertex without one.
// triangles: three vertex indices each; points: 3 x vertices.
std::vector<Vector3> vertex_normals(std::span<const std::uint32_t> triangles, std::span<const float> points);

// Barycentric weights of the point of triangle abc, of an area above 0, that is nearest to p: Ericson, "Real-Time
// Collision Detection" (2005), section 5.1.5.
std::array<float, 3> nearest_weights(Vector3 p, Vector3 a, Vector3 b, Vector3 c);

}  // namespace fb
