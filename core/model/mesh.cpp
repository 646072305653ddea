#include "model/mesh.h"

#include <algorithm>
#include <cmath>

#include "base/status.h"

namespace fb {

double Mesh::diagonal() const {
  double squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    float low = INFINITY, high = -INFINITY;
    for (std::size_t i = axis; i < points.size(); i += 3) {
      low = std::min(low, points[i]);
      high = std::max(high, points[i]);
    }
    if (high > low) squared += (double(high) - low) * (double(high) - low);
  }
  return std::sqrt(squared);
}

std::vector<std::uint32_t> Mesh::triangles() const {
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

void check(const Mesh& mesh) {
  if (mesh.points.empty() || mesh.points.size() % 3 != 0)
    fail(Status::bad_data, "rest mesh: %zu coordinates are not a positive multiple of 3", mesh.points.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (!std::isfinite(mesh.points[i])) fail(Status::not_finite, "rest mesh: vertex %zu is not finite", i / 3);
  std::size_t corners = 0;
  for (std::size_t p = 0; p < mesh.polygon_sizes.size(); ++p) {
    if (mesh.polygon_sizes[p] < 3)
      fail(Status::bad_data, "rest mesh: polygon %zu has %u corners", p, mesh.polygon_sizes[p]);
    for (std::uint32_t k = 0; k < mesh.polygon_sizes[p]; ++k, ++corners) {
      if (corners >= mesh.polygon_corners.size())
        fail(Status::bad_data, "rest mesh: polygon %zu runs past the %zu corners given", p,
             mesh.polygon_corners.size());
      if (mesh.polygon_corners[corners] >= mesh.vertex_count())
        fail(Status::bad_data, "rest mesh: polygon %zu names vertex %u of %zu", p, mesh.polygon_corners[corners],
             mesh.vertex_count());
    }
  }
  if (corners != mesh.polygon_corners.size())
    fail(Status::bad_data, "rest mesh: polygons use %zu of %zu corners", corners, mesh.polygon_corners.size());
  if (!(mesh.diagonal() > 0)) fail(Status::bad_data, "rest mesh: all vertices lie on one point");
}

}  // namespace fb
