#include <algorithm>

#include "archive/geometry/polygon_edges.h"
#include "archive/section_reader.h"
#include "archive/section_writer.h"
#include "base/checked.h"

namespace fb::archive {
namespace {

void write_sizes(ByteWriter& out, const Mesh& mesh, CornerCoding coding) {
  out.number(checked_u32(mesh.polygon_sizes.size(), "polygons"));
  out.number(checked_u32(mesh.polygon_corners.size(), "polygon corners"));
  out.planes(mesh.polygon_sizes);
  out.number(static_cast<std::uint32_t>(coding));
}

// Neighbouring polygons have neighbouring corners, so their differences are small and alike.
ByteWriter in_steps(const Mesh& mesh) {
  ByteWriter out;
  write_sizes(out, mesh, CornerCoding::steps);
  out.planes(corner_steps(mesh.polygon_sizes, mesh.polygon_corners));
  return out;
}

ByteWriter along_triangles(const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
  ByteWriter out;
  write_sizes(out, mesh, CornerCoding::along_triangles);
  const TriangleEdges edges(triangles, static_cast<std::uint32_t>(mesh.vertex_count()));
  std::vector<std::uint32_t> steps;
  std::vector<std::uint8_t> turns;
  const std::uint32_t* polygon = mesh.polygon_corners.data();
  std::span<const std::uint32_t> before;
  for (const std::uint32_t size : mesh.polygon_sizes) {
    steps.push_back(to_zigzag(polygon[0] - (before.empty() ? 0 : before[0])));
    const auto from = nearest_first(edges, polygon[0], predicted_second(before, polygon[0]));
    const auto turn = std::find_if(from.begin(), from.end(), [&](const auto& edge) { return edge.to == polygon[1]; });
    turns.push_back(static_cast<std::uint8_t>(turn - from.begin()));
    before = {polygon, size};
    polygon += size;
  }
  out.planes(steps);
  out.numbers(turns);
  return out;
}

// Whether the archive's own reader gets every corner back.
bool gives_back(const ByteWriter& section, const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
  try {
    Budget budget(UINT64_MAX);
    ByteReader in(section.bytes, "polygons", budget);
    Mesh read;
    read_polygons(in, static_cast<std::uint32_t>(mesh.vertex_count()), triangles, read);
    return read.polygon_corners == mesh.polygon_corners;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

std::vector<std::uint32_t> corner_steps(const std::vector<std::uint32_t>& sizes,
                                        const std::vector<std::uint32_t>& corners) {
  std::vector<std::uint32_t> steps;
  std::size_t at = 0;
  std::uint32_t previous_size = 0;
  for (const std::uint32_t size : sizes) {
    for (std::uint32_t k = 0; k < size; ++k, ++at)
      steps.push_back(to_zigzag(corners[at] - corner_before(corners, at, k, previous_size)));
    previous_size = size;
  }
  return steps;
}

ByteWriter write_polygons(const Mesh& mesh, const std::vector<std::uint32_t>& triangles) {
  // Only where every edge belongs to one triangle in each direction do triangles tell polygons.
  if (!triangles.empty())
    if (ByteWriter section = along_triangles(mesh, triangles); gives_back(section, mesh, triangles)) return section;
  return in_steps(mesh);
}

}  // namespace fb::archive
