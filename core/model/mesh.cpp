#include "model/mesh.h"

#include <cmath>

#include "base/status.h"

namespace fb {

namespace {

void check_uvs(const Mesh& mesh) {
  const std::size_t pairs = mesh.uvs.size() / 2;
  if (mesh.uvs.size() % 2 != 0)
    fail(Status::bad_data, "rest mesh: %zu numbers are not pairs of texture coordinates", mesh.uvs.size());
  for (std::size_t i = 0; i < mesh.uvs.size(); ++i)
    if (!std::isfinite(mesh.uvs[i])) fail(Status::not_finite, "rest mesh: texture coordinate %zu is not finite", i / 2);
  const std::size_t needed = pairs == 0 ? 0 : mesh.polygon_corners.size();
  if (mesh.uv_corners.size() != needed)
    fail(Status::bad_data, "rest mesh: %zu corners have texture coordinates where %zu should", mesh.uv_corners.size(),
         needed);
  for (std::size_t c = 0; c < needed; ++c)
    if (mesh.uv_corners[c] >= pairs)
      fail(Status::bad_data, "rest mesh: corner %zu names texture coordinate %u of %zu", c, mesh.uv_corners[c], pairs);
}

}  // namespace

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
  check_uvs(mesh);
  if (!(mesh.diagonal() > 0)) fail(Status::bad_data, "rest mesh: all vertices lie on one point");
}

}  // namespace fb
