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

std::array<float, 3> nearest_weights(Vector3 p, Vector3 a, Vector3 b, Vector3 c) {
  const Vector3 ab = b - a, ac = c - a;
  const float d1 = dot(ab, p - a), d2 = dot(ac, p - a);
  if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
  const float d3 = dot(ab, p - b), d4 = dot(ac, p - b);
  if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {1 - d1 / (d1 - d3), d1 / (d1 - d3), 0};
  const float d5 = dot(ab, p - c), d6 = dot(ac, p - c);
  if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {1 - d2 / (d2 - d6), 0, d2 / (d2 - d6)};
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const float w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {0, 1 - w, w};
  }
  const float sum = va + vb + vc;
  return {va / sum, vb / sum, vc / sum};
}

}  // namespace fb
