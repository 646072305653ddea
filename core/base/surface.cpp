#include "base/surface.h"

#include <algorithm>
#include <cmath>

namespace fb {

double box_diagonal(std::span<const float> points) {
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

std::vector<std::uint32_t> triangle_fans(std::span<const std::uint32_t> sizes, std::span<const std::uint32_t> corners) {
  std::vector<std::uint32_t> triangles;
  std::size_t first = 0;
  for (const std::uint32_t size : sizes) {
    for (std::uint32_t k = 1; k + 1 < size; ++k)
      triangles.insert(triangles.end(), {corners[first], corners[first + k], corners[first + k + 1]});
    first += size;
  }
  return triangles;
}

std::vector<Vector3> vertex_normals(std::span<const std::uint32_t> triangles, std::span<const float> points) {
  std::vector<Vector3> normals(points.size() / 3);
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const std::uint32_t a = triangles[t], b = triangles[t + 1], c = triangles[t + 2];
    const Vector3 p = vector_at(points.data(), a);
    const Vector3 twice_area = cross(vector_at(points.data(), b) - p, vector_at(points.data(), c) - p);
    for (const std::uint32_t v : {a, b, c}) normals[v] = normals[v] + twice_area;
  }
  for (Vector3& n : normals) n = normalized(n);
  return normals;
}

}  // namespace fb
