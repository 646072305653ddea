#include <algorithm>

#include "archive/container/byte_reader.h"
#include "archive/geometry/corner_coding.h"
#include "archive/geometry/geometry_reader.h"
#include "archive/geometry/geometry_writer.h"

namespace fb::archive {
namespace {

void write_sizes(ByteWriter& out, const Mesh& mesh, CornerCoding coding) {
  out.count(mesh.polygon_sizes.size(), "polygons");
  out.count(mesh.polygon_corners.size(), "polygon corners");
  out.planes(mesh.polygon_sizes);
  out.number(static_cast<std::uint32_t>(coding));
}

ByteWriter write_deltas(const Mesh& mesh) {
  ByteWriter out;
  write_sizes(out, mesh, CornerCoding::deltas);
  out.planes(corner_deltas(mesh.polygon_sizes, mesh.polygon_corners));
  return out;
}

// Not every mesh can be coded so: the result must be checked.
ByteWriter write_along_triangles(const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
  ByteWriter out;
  write_sizes(out, mesh, CornerCoding::along_triangles);
  const TriangleEdges edges(triangles, static_cast<std::uint32_t>(mesh.surface_vertex_count()));
  std::vector<std::uint32_t> deltas;
  std::vector<std::uint8_t> edge_indices;
  const std::uint32_t* polygon = mesh.polygon_corners.data();
  std::span<const std::uint32_t> previous;
  for (const std::uint32_t size : mesh.polygon_sizes) {
    deltas.push_back(to_zigzag(polygon[0] - (previous.empty() ? 0 : previous[0])));
    const auto from = sorted_edges(edges, polygon[0], predicted_second_corner(previous, polygon[0]));
    const auto edge = std::find_if(from.begin(), from.end(), [&](const auto& e) { return e.to == polygon[1]; });
    edge_indices.push_back(static_cast<std::uint8_t>(edge - from.begin()));
    previous = {polygon, size};
    polygon += size;
  }
  out.planes(deltas);
  out.numbers(edge_indices);
  return out;
}

// Whether the archive's own reader restores every corner.
bool is_lossless(const ByteWriter& section, const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
  try {
    MemoryBudget budget;
    ByteReader in(section.bytes, "polygons", budget);
    Mesh read;
    read_polygons(in, static_cast<std::uint32_t>(mesh.surface_vertex_count()), triangles, read);
    return read.polygon_corners == mesh.polygon_corners;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

ByteWriter write_polygons(const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
  // Triangles determine the polygons only where each half-edge belongs to one triangle.
  if (!triangles.empty())
    if (ByteWriter section = write_along_triangles(mesh, triangles); is_lossless(section, mesh, triangles))
      return section;
  return write_deltas(mesh);
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
