#include <algorithm>
#include <cmath>

#include "archive/container/container_layout.h"
#include "archive/geometry/corner_coding.h"
#include "archive/geometry/geometry_reader.h"

namespace fb::archive {
namespace {

// Corners coded as differences, to the end of the section, of polygons of these sizes. A corner must be below `limit`;
// `error` describes one that is not.
std::vector<std::uint32_t> read_corner_deltas(ByteReader& in, const std::vector<std::uint32_t>& sizes,
                                              std::uint32_t corners, std::uint32_t limit, const char* error) {
  std::vector<std::uint32_t> decoded = in.planes(corners, "corners");  // in place
  restore_corners(sizes, decoded);
  if (std::any_of(decoded.begin(), decoded.end(), [&](std::uint32_t corner) { return corner >= limit; }))
    in.corrupt(error);
  in.end();
  return decoded;
}

void read_along_triangles(ByteReader& in, std::uint32_t vertices, const std::vector<std::uint32_t>& triangles,
                          std::uint32_t corners, Mesh& mesh) {
  const auto deltas = in.temporary_planes(mesh.polygon_sizes.size(), "first corners");
  const auto edge_indices = in.temporary_numbers<std::uint8_t>(mesh.polygon_sizes.size(), "edge indices");
  in.end();
  const TriangleEdges edges(triangles, vertices, in.budget());
  in.budget().resize(mesh.polygon_corners, corners, "corners");
  std::uint32_t* polygon = mesh.polygon_corners.data();
  std::span<const std::uint32_t> previous;
  std::uint32_t first = 0;
  for (std::size_t p = 0; p < deltas.size(); ++p) {
    first += from_zigzag(deltas[p]);
    if (first >= vertices) in.corrupt("a polygon names a vertex that does not exist");
    const auto from = sorted_edges(edges, first, predicted_second_corner(previous, first));
    if (edge_indices[p] >= from.size()) in.corrupt("the first edge of a polygon is no edge of a triangle");
    polygon[0] = first;
    polygon[1] = from[edge_indices[p]].to;
    for (std::uint32_t k = 2; k < mesh.polygon_sizes[p]; ++k) {
      const auto edge = std::find_if(from.begin(), from.end(), [&](const auto& e) { return e.to == polygon[k - 1]; });
      if (edge == from.end()) in.corrupt("a polygon is no fan of triangles");
      polygon[k] = edge->opposite;
    }
    previous = {polygon, mesh.polygon_sizes[p]};
    polygon += mesh.polygon_sizes[p];
  }
}

}  // namespace

void read_polygons(ByteReader& in, std::uint32_t vertices, const std::vector<std::uint32_t>& triangles, Mesh& mesh) {
  const auto polygons = in.number<std::uint32_t>("the number of polygons");
  const auto corners = in.number<std::uint32_t>("the number of corners");
  mesh.polygon_sizes = in.planes(polygons, "polygon sizes");
  std::uint64_t sum = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) sum += size;
  if (sum != corners) in.corrupt("polygon sizes do not add up to the number of corners");
  for (const std::uint32_t size : mesh.polygon_sizes)
    if (size < 3) in.corrupt("a polygon has less than three corners");
  const auto coding = in.number<std::uint32_t>("the coding of corners");
  switch (static_cast<CornerCoding>(coding)) {
    case CornerCoding::deltas:
      mesh.polygon_corners =
          read_corner_deltas(in, mesh.polygon_sizes, corners, vertices, "a polygon names a vertex that does not exist");
      return;
    case CornerCoding::along_triangles:
      return read_along_triangles(in, vertices, triangles, corners, mesh);
  }
  fail(Status::unsupported, "%s has corners in unknown coding %u", in.where().c_str(), coding);
}

void read_uvs(ByteReader& in, std::uint32_t vertices, Mesh& mesh) {
  const auto pairs = in.number<std::uint32_t>("the number of texture coordinates");
  const auto coding = in.number<std::uint32_t>("the coding of texture coordinates");
  if (coding > static_cast<std::uint32_t>(UvCoding::by_vertex))
    fail(Status::unsupported, "%s has texture coordinates in unknown coding %u", in.where().c_str(), coding);
  if (pairs == 0) in.corrupt("there are no texture coordinates");
  const auto u = in.temporary_float_planes(pairs, "texture coordinates");
  const auto v = in.temporary_float_planes(pairs, "texture coordinates");
  in.budget().reserve(mesh.uvs, 2 * std::uint64_t(pairs), "texture coordinates");
  for (std::uint32_t i = 0; i < pairs; ++i) {
    if (!std::isfinite(u[i]) || !std::isfinite(v[i])) in.corrupt("a texture coordinate is not finite");
    mesh.uvs.push_back(u[i]);
    mesh.uvs.push_back(v[i]);
  }
  if (static_cast<UvCoding>(coding) == UvCoding::deltas) {
    const std::uint32_t corners = checked_u32(mesh.polygon_corners.size(), "corners");
    mesh.uv_corners = read_corner_deltas(in, mesh.polygon_sizes, corners, pairs,
                                         "a corner names a texture coordinate that does not exist");
    return;
  }
  if (pairs != vertices) in.corrupt("the number of texture coordinates is not that of the vertices");
  in.end();
  in.budget().reserve(mesh.uv_corners, mesh.polygon_corners.size(), "corners");
  mesh.uv_corners = mesh.polygon_corners;
}

}  // namespace fb::archive
