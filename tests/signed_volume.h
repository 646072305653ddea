// Whether surfaces are closed with their faces outwards.
#pragma once

#include <cstddef>
#include <vector>

#include "model/mesh.h"

namespace fb::test {

// Six times the volume that triangles enclose, above 0 where their faces point outwards: from the middle of `points`,
// of which `vertices` from `first` on are theirs. `corners`: three indices a triangle.
inline double signed_volume(const std::vector<float>& points, std::size_t first, std::size_t vertices,
                            const std::uint32_t* corners, std::size_t triangles) {
  double middle[3] = {};
  for (std::size_t i = 0; i < 3 * vertices; ++i) middle[i % 3] += double(points[3 * first + i]) / double(vertices);
  double volume = 0;
  for (std::size_t t = 0; t < triangles; ++t) {
    double p[3][3];
    for (std::size_t k = 0; k < 9; ++k)
      p[k / 3][k % 3] = double(points[3 * corners[3 * t + k / 3] + k % 3]) - middle[k % 3];
    volume += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) - p[0][1] * (p[1][0] * p[2][2] - p[1][2] * p[2][0]) +
              p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return volume;
}

// Of each part of a mesh of triangles.
inline std::vector<double> signed_volumes(const Mesh& mesh) {
  std::vector<double> volumes;
  std::size_t vertex = 0, corner = 0;
  for (const MeshPart& part : mesh.parts) {
    volumes.push_back(signed_volume(mesh.points, vertex, part.vertices, &mesh.polygon_corners[corner], part.polygons));
    vertex += part.vertices;
    corner += std::size_t{3} * part.polygons;
  }
  return volumes;
}

}  // namespace fb::test
