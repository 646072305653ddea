#include "model/mesh.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

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

// Fails unless the polygons, from `polygon` on, of a part whose vertices are first...end have no other vertices, and
// its material runs cover them. Advances `polygon` and `corner` past them.
void check_part(const Mesh& mesh, const MeshPart& part, std::size_t first, std::size_t end, std::size_t& polygon,
                std::size_t& corner) {
  const char* name = part.name.c_str();
  if (part.vertices == 0) fail(Status::bad_data, "mesh \"%s\" has no vertices", name);
  if (end > mesh.surface_vertex_count() || part.polygons > mesh.polygon_sizes.size() - polygon)
    fail(Status::bad_data, "mesh \"%s\" has more vertices or polygons than are left", name);
  for (std::uint32_t p = 0; p < part.polygons; ++p, ++polygon)
    for (std::uint32_t k = 0; k < mesh.polygon_sizes[polygon]; ++k, ++corner)
      if (mesh.polygon_corners[corner] < first || mesh.polygon_corners[corner] >= end)
        fail(Status::bad_data, "mesh \"%s\": polygon %zu has vertex %u of another mesh", name, polygon,
             mesh.polygon_corners[corner]);
  std::uint64_t covered = 0;
  for (const MaterialRun& run : part.materials) {
    if (run.polygons == 0) fail(Status::bad_data, "mesh \"%s\" has a material without polygons", name);
    covered += run.polygons;
  }
  if (covered != part.polygons)
    fail(Status::bad_data, "mesh \"%s\": materials of %llu polygons for %u", name, (unsigned long long)covered,
         part.polygons);
}

void check_parts(const Mesh& mesh) {
  std::unordered_set<std::string_view> names;
  std::size_t vertex = 0, polygon = 0, corner = 0;
  for (const MeshPart& part : mesh.parts) {
    if (part.name.empty()) fail(Status::bad_data, "a mesh without a name");
    if (!names.insert(part.name).second) fail(Status::bad_data, "two meshes named \"%s\"", part.name.c_str());
    check_part(mesh, part, vertex, vertex + part.vertices, polygon, corner);
    vertex += part.vertices;
  }
  if (vertex != mesh.surface_vertex_count() || polygon != mesh.polygon_sizes.size())
    fail(Status::bad_data, "the meshes have %zu vertices and %zu polygons of %zu and %zu", vertex, polygon,
         mesh.surface_vertex_count(), mesh.polygon_sizes.size());
}

}  // namespace

std::vector<std::uint32_t> Mesh::part_ends() const {
  std::vector<std::uint32_t> ends;
  for (const MeshPart& part : parts) ends.push_back((ends.empty() ? 0 : ends.back()) + part.vertices);
  if (parts.empty()) ends.push_back(static_cast<std::uint32_t>(surface_vertex_count()));
  if (carrier_vertices > 0) ends.push_back(static_cast<std::uint32_t>(vertex_count()));
  return ends;
}

void check(const Mesh& mesh) {
  if (mesh.points.empty() || mesh.points.size() % 3 != 0)
    fail(Status::bad_data, "rest mesh: %zu coordinates are not a positive multiple of 3", mesh.points.size());
  if (mesh.carrier_vertices >= mesh.vertex_count()) fail(Status::bad_data, "rest mesh: it has no vertices");
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
      if (mesh.polygon_corners[corners] >= mesh.surface_vertex_count())
        fail(Status::bad_data, "rest mesh: polygon %zu names vertex %u of %zu", p, mesh.polygon_corners[corners],
             mesh.surface_vertex_count());
    }
  }
  if (corners != mesh.polygon_corners.size())
    fail(Status::bad_data, "rest mesh: polygons use %zu of %zu corners", corners, mesh.polygon_corners.size());
  check_uvs(mesh);
  if (!mesh.parts.empty()) check_parts(mesh);
  check(mesh.driven, mesh.surface_vertex_count());
  if (!(mesh.diagonal() > 0)) fail(Status::bad_data, "rest mesh: all vertices lie on one point");
}

}  // namespace fb
