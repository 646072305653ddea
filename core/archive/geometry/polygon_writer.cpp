#include <algorithm>
#include <span>

#include "archive/container/byte_writer.h"
#include "archive/geometry/corner_coding.h"
#include "archive/geometry/geometry_reader.h"
#include "archive/geometry/geometry_writer.h"

namespace fb::archive {
namespace {

// The edge index of a polygon, if its other corners follow from it; else no_edge. `previous`: the polygon before it
// that has one.
std::uint8_t edge_index_of(std::span<const std::uint32_t> polygon, const TriangleEdges& edges,
                           std::span<const std::uint32_t> previous) {
  if (polygon.size() > max_fan_corners) return no_edge;
  SortedEdges sorted;
  const auto from = sorted_edges(edges, polygon[0], predicted_second_corner(previous, polygon[0]), sorted);
  const auto edge_to = [&](std::uint32_t vertex) {
    return std::find_if(from.begin(), from.end(), [&](const auto& e) { return e.to == vertex; });
  };
  for (std::size_t k = 1; k < polygon.size(); ++k) {
    const auto edge = edge_to(polygon[k]);
    const bool is_last = k + 1 == polygon.size();
    if (!is_last && (edge == from.end() || edge->opposite != polygon[k + 1])) return no_edge;
  }
  return static_cast<std::uint8_t>(edge_to(polygon[1]) - from.begin());
}

}  // namespace

ByteWriter write_polygons(const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
  ByteWriter out;
  out.count(mesh.polygon_sizes.size(), "polygons");
  out.count(mesh.polygon_corners.size(), "polygon corners");
  out.planes(mesh.polygon_sizes);
  const TriangleEdges edges(triangles, static_cast<std::uint32_t>(mesh.surface_vertex_count()));
  std::vector<std::uint8_t> edge_indices;
  std::vector<std::uint32_t> firsts, other_sizes, other_corners;
  std::span<const std::uint32_t> previous, left = mesh.polygon_corners;
  for (const std::uint32_t size : mesh.polygon_sizes) {
    const auto polygon = left.first(size);
    left = left.subspan(size);
    edge_indices.push_back(edge_index_of(polygon, edges, previous));
    if (edge_indices.back() == no_edge) {
      other_sizes.push_back(size);
      other_corners.insert(other_corners.end(), polygon.begin(), polygon.end());
      continue;
    }
    firsts.push_back(to_zigzag(polygon[0] - (previous.empty() ? 0 : previous[0])));
    previous = polygon;
  }
  out.numbers(edge_indices);
  out.planes(firsts);
  out.planes(corner_deltas(other_sizes, other_corners));
  return out;
}

ByteWriter write_uvs(const Mesh& mesh) {
  const std::size_t pairs = mesh.uvs.size() / 2;
  const bool by_vertex = pairs == mesh.surface_vertex_count() && mesh.uv_corners == mesh.polygon_corners;
  ByteWriter out;
  out.count(pairs, "texture coordinates");
  out.number(static_cast<std::uint32_t>(by_vertex ? UvCoding::by_vertex : UvCoding::deltas));
  for (std::size_t axis = 0; axis < 2; ++axis) {
    std::vector<float> coordinates;
    for (std::size_t i = axis; i < mesh.uvs.size(); i += 2) coordinates.push_back(mesh.uvs[i]);
    out.float_planes(coordinates);
  }
  if (!by_vertex) out.planes(corner_deltas(mesh.polygon_sizes, mesh.uv_corners));
  return out;
}

}  // namespace fb::archive
