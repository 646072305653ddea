#include "base/surface.h"

namespace fb {

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
