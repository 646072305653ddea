#include "golden_edits.h"

namespace fb {
namespace {

// A section `polygons` of one polygon: its size and edge index, and numbers below 256 that follow: its first corner if
// it is along triangles, else its corners.
Bytes one_polygon(std::uint8_t size, std::uint8_t edge_index, const std::vector<std::uint8_t>& following) {
  Bytes bytes = numbers({1, size, size});  // a table of one number is the number
  append(bytes, edge_index);
  for (std::size_t plane = 0; plane < 4; ++plane)
    for (const std::uint8_t number : following) append(bytes, std::uint8_t(plane == 0 ? number : 0));
  return bytes;
}

// A mesh that nothing moves, of which all numbers of predictors are 0, whatever its polygons are.
void write_polygon(const RejectedWriter& out, const char* file, const Mesh& mesh, const Bytes& polygons) {
  PackedModel model = smallest();
  model.rest = mesh;
  model.row_blocks = {{0, static_cast<std::uint32_t>(mesh.points.size()), {}, {}}};
  out.write(file, edited(
                      [&](ArchiveEditor& archive) {
                        archive["polygons"].set(polygons);
                        archive["basis-values"].set(constant_symbols(25, 4, 0, 0));
                      },
                      model));
}

Mesh mesh_of_triangles(std::uint32_t vertices, const std::vector<std::uint32_t>& corners) {
  Mesh mesh;
  for (std::uint32_t v = 0; v < vertices; ++v) mesh.points.insert(mesh.points.end(), {float(v), float(v * v), 0});
  mesh.polygon_sizes.assign(corners.size() / 3, 3);
  mesh.polygon_corners = corners;
  return mesh;
}

void write_rejected_polygons(const RejectedWriter& out) {
  constexpr std::uint8_t no_edge = 255;
  const Mesh triangle = mesh_of_triangles(3, {0, 1, 2});
  write_polygon(out, "corrupt-polygon-small.fbk", triangle, one_polygon(2, no_edge, {0, 2}));
  write_polygon(out, "corrupt-polygon-corner.fbk", triangle, one_polygon(3, no_edge, {0, 2, 4}));
  write_polygon(out, "corrupt-polygon-fan.fbk", triangle, one_polygon(4, 0, {0}));
  write_polygon(out, "corrupt-edges-twice.fbk", mesh_of_triangles(4, {0, 1, 2, 0, 1, 3}), one_polygon(3, 0, {0}));
  // Round and round a vertex of six triangles.
  write_polygon(out, "corrupt-polygon-large.fbk", regular(true).rest, one_polygon(67, 0, {2 * 15}));
  std::vector<std::uint32_t> fan;
  for (std::uint32_t v = 1; v <= 65; ++v) fan.insert(fan.end(), {v, v + 1, 0});
  write_polygon(out, "corrupt-edges-65.fbk", mesh_of_triangles(67, fan), one_polygon(3, 0, {0}));
}

}  // namespace

void write_rejected_geometry(const RejectedWriter& out) {
  out.patched("corrupt-vertices.fbk", "definition", 19, std::uint32_t(31));
  out.write("corrupt-up-axis.fbk", changed("definition", [](Bytes& b) { b[18] = std::byte('x'); }));
  out.patched("corrupt-zero-in-name.fbk", "definition", 4, std::uint8_t(0));
  out.patched("corrupt-no-vertices.fbk", "definition", 19, std::uint32_t(0));
  out.patched("corrupt-sizes.fbk", "polygons", 4, std::uint32_t(7));
  // The tiny model's mesh of 30 vertices has 34 points, after which the Draco data begins.
  constexpr std::size_t draco = 12 + 4 * 34;
  out.patched("corrupt-points.fbk", "geometry", 0, std::uint32_t(29));
  out.patched("corrupt-point-vertex.fbk", "geometry", 12, std::uint8_t(61));
  out.patched("corrupt-draco.fbk", "geometry", draco, std::uint8_t(0));
  out.patched("corrupt-draco-points.fbk", "geometry", draco + 12, std::uint8_t(33));
  out.patched("corrupt-draco-seams.fbk", "geometry", draco + 14, std::uint8_t(1));
  out.patched("corrupt-draco-symbols.fbk", "geometry", draco + 15, std::uint8_t(1));
  out.patched("corrupt-triangles.fbk", "geometry", 4, std::uint32_t(1));
  out.patched("corrupt-grid.fbk", "geometry", 8, 0.75f);
  out.patched("corrupt-floats-on-grid.fbk", "geometry", 8, 0.5f);
  const PackedModel on_grid = regular(true);
  out.patched("corrupt-edge-index.fbk", "polygons", 8 + 4 * 20 + 7, std::uint8_t(6), on_grid);
  out.patched("corrupt-first-corner.fbk", "polygons", 8 + 4 * 20 + 20, std::uint8_t(60), on_grid);
  out.patched("corrupt-corner-missing.fbk", "polygons", 8 + 4 * 20 + 7, std::uint8_t(255), on_grid);
  out.patched("corrupt-coarse-grid.fbk", "geometry", 8, 0x1p126f, on_grid);
  out.patched("corrupt-grid-for-floats.fbk", "geometry", 8, 0.0f, on_grid);
  const PackedModel seam = with_uvs(give_uvs), by_vertex = with_uvs(give_uvs_by_vertex);
  out.patched("corrupt-no-uvs.fbk", "uvs", 0, std::uint32_t(0), seam);
  out.patched("corrupt-uvs-by-vertex.fbk", "uvs", 4, std::uint32_t(1), seam);
  out.patched("corrupt-uv-corner.fbk", "uvs", 8 + 8 * 60, std::uint8_t(200), seam);
  out.patched("corrupt-uv-deltas.fbk", "uvs", 4, std::uint32_t(0), by_vertex);
  const auto make_infinite = [](Bytes& b) {
    b[8 + 2 * 60] = std::byte(0x80);
    b[8 + 3 * 60] = std::byte(0x7f);
  };
  out.write("corrupt-uv-infinite.fbk", changed("uvs", make_infinite, seam));
  write_rejected_polygons(out);
  out.patched("unsupported-uvs.fbk", "uvs", 4, std::uint32_t(2), seam);
}

}  // namespace fb
