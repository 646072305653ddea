#include <algorithm>

#include "archive/container/layout.h"
#include "archive/geometry/polygon_edges.h"
#include "archive/section_reader.h"

namespace fb::archive {
namespace {

void read_along_triangles(ByteReader& in, std::uint32_t vertices, const std::vector<std::uint32_t>& triangles,
                          std::uint32_t corners, Mesh& mesh) {
  const std::vector<std::uint32_t> steps = in.planes32(mesh.polygon_sizes.size(), "first corners");
  const std::vector<std::uint8_t> turns = in.numbers<std::uint8_t>(mesh.polygon_sizes.size(), "turns");
  in.end();
  in.budget().take(triangles.size(), sizeof(TriangleEdges::Edge), "edges");
  in.budget().take(std::uint64_t(vertices) + corners, sizeof(std::uint32_t), "edges and corners");
  const TriangleEdges edges(triangles, vertices);
  mesh.polygon_corners.resize(corners);
  std::uint32_t* polygon = mesh.polygon_corners.data();
  std::span<const std::uint32_t> before;
  std::uint32_t first = 0;
  for (std::size_t p = 0; p < steps.size(); ++p) {
    first += from_zigzag(steps[p]);
    if (first >= vertices) in.damaged("a polygon names a vertex that does not exist");
    const auto from = nearest_first(edges, first, predicted_second(before, first));
    if (turns[p] >= from.size()) in.damaged("a polygon begins along no triangle");
    polygon[0] = first;
    polygon[1] = from[turns[p]].to;
    for (std::uint32_t k = 2; k < mesh.polygon_sizes[p]; ++k) {
      const auto edge = std::find_if(from.begin(), from.end(), [&](const auto& e) { return e.to == polygon[k - 1]; });
      if (edge == from.end()) in.damaged("a polygon goes on along no triangle");
      polygon[k] = edge->next;
    }
    before = {polygon, mesh.polygon_sizes[p]};
    polygon += mesh.polygon_sizes[p];
  }
}

}  // namespace

std::uint32_t read_polygon_sizes(ByteReader& in, Mesh& mesh) {
  const auto polygons = in.number<std::uint32_t>("the number of polygons");
  const auto corners = in.number<std::uint32_t>("the number of corners");
  mesh.polygon_sizes = in.planes32(polygons, "polygon sizes");
  std::uint64_t sum = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) sum += size;
  if (sum != corners) in.damaged("polygon sizes do not add up to the number of corners");
  return corners;
}

std::vector<std::uint32_t> read_corner_steps(ByteReader& in, const std::vector<std::uint32_t>& sizes,
                                             std::uint32_t corners, std::uint32_t limit, const char* what) {
  std::vector<std::uint32_t> found = in.planes32(corners, "corners");
  // Each step is undone from corners already decoded in place.
  std::size_t at = 0;
  std::uint32_t previous_size = 0;
  for (const std::uint32_t size : sizes) {
    for (std::uint32_t k = 0; k < size; ++k, ++at) {
      found[at] = corner_before(found, at, k, previous_size) + from_zigzag(found[at]);
      if (found[at] >= limit) in.damaged(what);
    }
    previous_size = size;
  }
  in.end();
  return found;
}

void read_polygon_steps(ByteReader& in, std::uint32_t vertices, std::uint32_t corners, Mesh& mesh) {
  mesh.polygon_corners =
      read_corner_steps(in, mesh.polygon_sizes, corners, vertices, "a polygon names a vertex that does not exist");
}

void read_polygons(ByteReader& in, std::uint32_t vertices, const std::vector<std::uint32_t>& triangles, Mesh& mesh) {
  const std::uint32_t corners = read_polygon_sizes(in, mesh);
  for (const std::uint32_t size : mesh.polygon_sizes)
    if (size < 3) in.damaged("a polygon has less than three corners");
  const auto coding = in.number<std::uint32_t>("the coding of corners");
  switch (static_cast<CornerCoding>(coding)) {
    case CornerCoding::steps:
      return read_polygon_steps(in, vertices, corners, mesh);
    case CornerCoding::along_triangles:
      return read_along_triangles(in, vertices, triangles, corners, mesh);
  }
  fail(Status::unsupported, "%s has corners in unknown coding %u", in.where().c_str(), coding);
}

}  // namespace fb::archive
