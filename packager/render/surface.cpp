#include "render/surface.h"

#include <algorithm>

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

std::vector<float> vertex_hollowness(std::span<const std::uint32_t> triangles, std::span<const float> points,
                                     std::span<const Vector3> normals) {
  // An edge seen from the normal rises in a groove and falls on a ridge: the mean sine of that angle, which does not
  // depend on the mesh's units, smoothed once over the neighbours.
  const std::size_t vertices = normals.size();
  const auto mean_over_edges = [&](auto&& value) {
    std::vector<float> sums(vertices), counts(vertices);
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3)
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t a = triangles[t + k], b = triangles[t + (k + 1) % 3];
        sums[a] += value(a, b);
        sums[b] += value(b, a);
        ++counts[a];
        ++counts[b];
      }
    for (std::size_t v = 0; v < vertices; ++v) sums[v] /= std::max(counts[v], 1.0f);
    return sums;
  };
  const auto rise = mean_over_edges([&](std::uint32_t from, std::uint32_t to) {
    const Vector3 edge = vector_at(points.data(), to) - vector_at(points.data(), from);
    return dot(normalized(edge), normals[from]);
  });
  return mean_over_edges([&](std::uint32_t from, std::uint32_t to) { return 0.5f * (rise[from] + rise[to]); });
}

}  // namespace fb
