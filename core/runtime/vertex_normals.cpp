#include "runtime/vertex_normals.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"
#include "model/mesh_scale.h"
#include "runtime/csr_table.h"

namespace fb::runtime {

VertexNormals::VertexNormals(const Mesh& mesh, std::span<const std::uint32_t> baked_index,
                             std::span<const std::uint32_t> block_rows, std::pmr::memory_resource& memory,
                             std::pmr::memory_resource& heap)
    : graph_(mesh, baked_index, block_rows, memory, heap),
      quads_(&memory),
      fan_quads_(&memory),
      sums_(memory),
      scale_(std::ldexp(1.0f, std::clamp(scale_exponent(mesh), -126, 126))) {
  struct Polygon {
    std::uint32_t index, first_corner;
  };
  const std::size_t polygons = mesh.polygon_sizes.size();
  CsrBuilder<Polygon> by_block(block_rows.size() - 1, polygons, heap);
  quads_.reserve(polygons + 1);
  std::size_t fan_quads = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) fan_quads += (size - 3) / 2;
  fan_quads_.reserve(fan_quads);
  std::uint32_t first = 0;
  for (std::uint32_t p = 0; p < polygons; ++p) {
    const std::uint32_t size = mesh.polygon_sizes[p];
    const auto row = [&](std::uint32_t k) {
      const std::uint32_t vertex = mesh.polygon_corners[first + k % size];
      return 3 * (baked_index.empty() ? vertex : baked_index[vertex]);
    };
    const auto quad = [&](std::uint32_t k) { return Quad{{row(0), row(k), row(k + 1), row(k + 2)}}; };
    quads_.push_back(quad(1));
    for (std::uint32_t k = 3; k + 1 < size; k += 2) fan_quads_.push_back({p, quad(k)});
    const auto block = std::upper_bound(block_rows.begin(), block_rows.end(), row(0)) - block_rows.begin() - 1;
    by_block.add(static_cast<std::size_t>(block), {p, first});
    first += size;
  }
  if (polygons % 2 != 0) quads_.push_back({});
  CsrTable<Polygon> sorted(heap);
  by_block.build(sorted);
  std::pmr::vector<std::uint32_t> last_polygon(mesh.surface_vertex_count(), UINT32_MAX, &heap);  // counts once a vertex
  CsrBuilder<std::uint32_t> at_vertex(mesh.surface_vertex_count(), mesh.polygon_corners.size(), heap);
  for (const Polygon& polygon : sorted.entries)
    for (std::uint32_t k = 0; k < mesh.polygon_sizes[polygon.index]; ++k) {
      const std::uint32_t v = mesh.polygon_corners[polygon.first_corner + k];
      if (last_polygon[v] != polygon.index) at_vertex.add(v, polygon.index);
      last_polygon[v] = polygon.index;
    }
  CsrTable<std::uint32_t> incident(heap);
  at_vertex.build(incident);
  sums_.build(incident);
}

void VertexNormals::run(const PoseKernels& kernels, const float* rows, std::span<const std::uint8_t> moved,
                        PolygonGraph::State& state, const Spread& spread) const {
  float* const areas = state.vectors.data() + no_polygon_floats;
  const auto compute_areas = [&](std::size_t begin, std::size_t end) {
    kernels.quad_areas(quads_.data() + begin, end - begin, rows, scale_, areas + 4 * begin);
    const auto first = std::lower_bound(fan_quads_.begin(), fan_quads_.end(), begin,
                                        [](const FanQuad& fan, std::size_t p) { return fan.polygon < p; });
    for (auto fan = first; fan != fan_quads_.end() && fan->polygon < end; ++fan) {
      const Quad two[2] = {fan->quad, fan->quad};
      float more[8];
      kernels.quad_areas(two, 2, rows, scale_, more);
      for (std::size_t i = 0; i < 4; ++i) areas[4 * std::size_t(fan->polygon) + i] += more[i];
    }
  };
  graph_.run(moved, state, spread, compute_areas, [&](std::size_t begin, std::size_t end) {
    kernels.vertex_normals(sums_.around(begin, end), state.vectors.data(), state.results.data());
  });
}

}  // namespace fb::runtime
