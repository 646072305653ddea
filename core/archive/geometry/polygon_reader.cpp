#include <algorithm>
#include <cmath>
#include <utility>

#include "archive/container/container_layout.h"
#include "archive/geometry/corner_coding.h"
#include "archive/geometry/geometry_reader.h"

namespace fb::archive {
namespace {

// Restores corners coded as differences, of polygons of these sizes, in place. A corner must be below `limit`; `error`
// describes one that is not.
void decode_corner_deltas(ByteReader& in, std::span<const std::uint32_t> sizes, std::span<std::uint32_t> decoded,
                          std::uint32_t limit, const char* error) {
  restore_corners(sizes, decoded);
  if (std::any_of(decoded.begin(), decoded.end(), [&](std::uint32_t corner) { return corner >= limit; }))
    in.corrupt(error);
  in.end();
}

// Walks along triangles from one polygon to the next.
class TriangleWalk {
 public:
  TriangleWalk(ByteReader& in, std::uint32_t vertices, const std::vector<std::uint32_t>& triangles)
      : in_(in), vertices_(vertices), edges_(triangles, vertices, in.budget()) {}

  // Fills a polygon. `first`: its first corner, as the zigzag difference from that of the polygon before.
  void fill(std::span<std::uint32_t> polygon, std::uint32_t first, std::uint8_t edge_index) {
    first_ += from_zigzag(first);
    if (first_ >= vertices_) in_.corrupt(no_vertex);
    const auto from = sorted_edges(edges_, first_, predicted_second_corner(previous_, first_), sorted_);
    if (edge_index >= from.size()) in_.corrupt("the first edge of a polygon is no edge of a triangle");
    polygon[0] = first_;
    polygon[1] = from[edge_index].to;
    for (std::size_t k = 2; k < polygon.size(); ++k) {
      const auto edge = std::find_if(from.begin(), from.end(), [&](const auto& e) { return e.to == polygon[k - 1]; });
      if (edge == from.end()) in_.corrupt("a polygon is no fan of triangles");
      polygon[k] = edge->opposite;
    }
    previous_ = polygon;
  }

  static constexpr const char* no_vertex = "a polygon names a vertex that does not exist";

 private:
  ByteReader& in_;
  std::uint32_t vertices_;
  TriangleEdges edges_;
  SortedEdges sorted_{};
  std::span<const std::uint32_t> previous_;
  std::uint32_t first_ = 0;
};

void read_corners(ByteReader& in, std::uint32_t vertices, const std::vector<std::uint32_t>& triangles,
                  std::uint32_t corners, Mesh& mesh) {
  const auto edge_indices = in.temporary_numbers<std::uint8_t>(mesh.polygon_sizes.size(), "edge indices");
  std::pmr::vector<std::uint32_t> other_sizes(&in.budget());
  std::uint64_t other_corners = 0;
  for (std::size_t p = 0; p < edge_indices.size(); ++p)
    if (edge_indices[p] == no_edge) {
      other_sizes.push_back(mesh.polygon_sizes[p]);
      other_corners += mesh.polygon_sizes[p];
    } else if (mesh.polygon_sizes[p] > max_fan_corners) {
      in.corrupt("a polygon along triangles has too many corners");
    }
  const auto firsts = in.temporary_planes(edge_indices.size() - other_sizes.size(), "first corners");
  auto others = in.temporary_planes(other_corners, "corners");
  decode_corner_deltas(in, other_sizes, others, vertices, TriangleWalk::no_vertex);
  in.budget().resize(mesh.polygon_corners, corners, "corners");
  TriangleWalk walk(in, vertices, triangles);
  auto first = firsts.begin();
  auto other = others.begin();
  std::uint32_t* polygon = mesh.polygon_corners.data();
  for (std::size_t p = 0; p < edge_indices.size(); ++p) {
    const std::uint32_t size = mesh.polygon_sizes[p];
    if (edge_indices[p] == no_edge)
      std::copy_n(std::exchange(other, other + size), size, polygon);
    else
      walk.fill({polygon, size}, *first++, edge_indices[p]);
    polygon += size;
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
  read_corners(in, vertices, triangles, corners, mesh);
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
    mesh.uv_corners = in.planes(corners, "corners");
    return decode_corner_deltas(in, mesh.polygon_sizes, mesh.uv_corners, pairs,
                                "a corner names a texture coordinate that does not exist");
  }
  if (pairs != vertices) in.corrupt("the number of texture coordinates is not that of the vertices");
  in.end();
  in.budget().reserve(mesh.uv_corners, mesh.polygon_corners.size(), "corners");
  mesh.uv_corners = mesh.polygon_corners;
}

}  // namespace fb::archive
