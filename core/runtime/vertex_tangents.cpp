#include "runtime/vertex_tangents.h"

#include <algorithm>

#include "base/checked.h"
#include "runtime/csr_table.h"

namespace fb::runtime {

VertexTangents::VertexTangents(const Mesh& mesh, std::span<const std::uint32_t> baked_index,
                               std::pmr::memory_resource& memory, std::pmr::memory_resource& heap)
    : weights_(&memory), extra_corners_(&memory), sums_(memory), signs_(&memory) {
  if (mesh.uvs.empty()) return;
  const std::size_t vertices = mesh.surface_vertex_count(), polygons = mesh.polygon_sizes.size();
  std::pmr::vector<double> areas(vertices, &heap);
  CsrBuilder<std::uint32_t> at_vertex(vertices, mesh.polygon_corners.size(), heap);
  weights_.resize((polygons + 1) / 2 * 2);
  std::size_t extra_corners = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) extra_corners += std::max(size, 4u) - 4;
  extra_corners_.reserve(extra_corners);
  std::size_t first = 0;
  for (std::uint32_t p = 0; p < polygons; ++p) {
    const std::uint32_t size = mesh.polygon_sizes[p];
    const auto uv = [&](std::uint32_t k, int axis) {
      return double(mesh.uvs[2 * std::size_t(mesh.uv_corners[first + k % size]) + axis]);
    };
    double area = 0;  // twice the polygon's signed area in texture space
    for (std::uint32_t k = 0; k < size; ++k) area += uv(k, 0) * uv(k + 1, 1) - uv(k + 1, 0) * uv(k, 1);
    const double side = area > 0 ? 1 : area < 0 ? -1 : 0;
    for (std::uint32_t k = 0; k < size; ++k) {
      const std::uint32_t vertex = mesh.polygon_corners[first + k];
      const auto weight = static_cast<float>(side * (uv(k + 1, 1) - uv(k + size - 1, 1)));
      if (k >= 4)
        extra_corners_.push_back({p, 3 * (baked_index.empty() ? vertex : baked_index[vertex]), weight});
      else if (k > 0)
        weights_[p].of[k - 1] = weight;
      at_vertex.add(vertex, p);
      areas[vertex] += area;
    }
    first += size;
  }
  checked_u32(first, "polygon corners");
  CsrTable<std::uint32_t> incident(heap);
  at_vertex.build(incident);
  sums_.build(incident);
  signs_.resize(mesh.vertex_count(), 1);
  std::transform(areas.begin(), areas.end(), signs_.begin(), [](double area) { return area < 0 ? -1.0f : 1.0f; });
}

void VertexTangents::run(const PoseKernels& kernels, const float* rows, std::span<const std::uint8_t> moved,
                         const VertexNormals& of_normals, const float* normals, PolygonGraph::State& state,
                         const Spread& spread) const {
  const std::span<const Quad> quads = of_normals.quads();
  float* const integrals = state.vectors.data() + no_polygon_floats;
  const auto compute_integrals = [&](std::size_t begin, std::size_t end) {
    kernels.quad_integrals(quads.data() + begin, weights_.data() + begin, end - begin, rows, integrals + 4 * begin);
    const auto first = std::lower_bound(extra_corners_.begin(), extra_corners_.end(), begin,
                                        [](const ExtraCorner& corner, std::size_t p) { return corner.polygon < p; });
    for (auto extra = first; extra != extra_corners_.end() && extra->polygon < end; ++extra)
      for (std::size_t i = 0; i < 3; ++i)
        integrals[4 * std::size_t(extra->polygon) + i] +=
            extra->weight * (rows[extra->row + i] - rows[quads[extra->polygon].offset[0] + i]);
  };
  of_normals.graph().run(moved, state, spread, compute_integrals, [&](std::size_t begin, std::size_t end) {
    kernels.vertex_tangents(sums_.around(begin, end), state.vectors.data(), normals, state.results.data());
  });
}

}  // namespace fb::runtime
