#include "runtime/vertex_tangents.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"
#include "runtime/float_mode.h"

namespace fb::runtime {

VertexTangents::State::State(const VertexTangents& tangents, std::pmr::memory_resource& memory)
    : integrals_(3 * tangents.polygon_offsets_.size(), &memory),
      tangents_(tangents.at_rest_.begin(), tangents.at_rest_.end(), &memory),
      moved_(tangents.block_count_, &memory) {
  if (!tangents_.empty()) tangents_.push_back(0);
}

VertexTangents::VertexTangents(const Mesh& mesh, std::span<const std::uint32_t> baked_index,
                               const VertexNormals& normals, std::pmr::memory_resource& memory,
                               std::pmr::memory_resource& heap)
    : corners_(&memory),
      polygon_offsets_(&memory),
      incident_(memory),
      signs_(&memory),
      at_rest_(&memory),
      block_count_(normals.block_count()) {
  if (mesh.uvs.empty()) return;
  with_float_mode([&] { compute_rest(mesh, baked_index, normals.at_rest(), heap); });
}

void VertexTangents::compute_rest(const Mesh& mesh, std::span<const std::uint32_t> baked_index,
                                  std::span<const float> normals, std::pmr::memory_resource& heap) {
  const std::size_t vertices = mesh.vertex_count();
  const auto baked = [&](std::uint32_t vertex) { return baked_index.empty() ? vertex : baked_index[vertex]; };
  std::pmr::vector<double> areas(vertices, &heap);
  CsrBuilder<std::uint32_t> at_vertex(vertices, mesh.polygon_corners.size(), heap);
  corners_.reserve(mesh.polygon_corners.size());
  polygon_offsets_.reserve(mesh.polygon_sizes.size() + 1);
  signs_.reserve(vertices);
  std::size_t first = 0;
  for (std::uint32_t p = 0; p < mesh.polygon_sizes.size(); ++p) {
    const std::uint32_t size = mesh.polygon_sizes[p];
    const auto uv = [&](std::uint32_t k, int axis) {
      return double(mesh.uvs[2 * std::size_t(mesh.uv_corners[first + k % size]) + axis]);
    };
    double area = 0;  // twice the polygon's signed area in texture space
    for (std::uint32_t k = 0; k < size; ++k) area += uv(k, 0) * uv(k + 1, 1) - uv(k + 1, 0) * uv(k, 1);
    const double side = area > 0 ? 1 : area < 0 ? -1 : 0;
    polygon_offsets_.push_back(checked_u32(corners_.size(), "polygon corners"));
    for (std::uint32_t k = 0; k < size; ++k) {
      const std::uint32_t vertex = mesh.polygon_corners[first + k];
      corners_.push_back({baked(vertex), static_cast<float>(side * (uv(k + 1, 1) - uv(k + size - 1, 1)))});
      at_vertex.add(baked(vertex), p);
      areas[vertex] += area;
    }
    first += size;
  }
  polygon_offsets_.push_back(checked_u32(corners_.size(), "polygon corners"));
  at_vertex.build(incident_);
  for (const double area : areas) signs_.push_back(area < 0 ? -1.0f : 1.0f);

  std::pmr::vector<float> rows(3 * vertices, &heap), integrals(3 * polygon_offsets_.size(), &heap);
  for (std::size_t v = 0; v < vertices; ++v)
    std::copy_n(mesh.points.begin() + 3 * v, 3, rows.begin() + 3 * baked(static_cast<std::uint32_t>(v)));
  at_rest_.resize(3 * vertices);
  compute_integrals(rows.data(), integrals.data());
  compute_tangents(0, static_cast<std::uint32_t>(vertices), integrals.data(), normals.data(), at_rest_.data());
}

void VertexTangents::compute_integrals(const float* rows, float* integrals) const {
  for (std::size_t p = 0; p + 1 < polygon_offsets_.size(); ++p) {
    const float* const origin = rows + 3 * std::size_t(corners_[polygon_offsets_[p]].vertex);
    float sum[3] = {};
    for (std::uint32_t k = polygon_offsets_[p] + 1; k < polygon_offsets_[p + 1]; ++k) {
      const float* const corner = rows + 3 * std::size_t(corners_[k].vertex);
      for (int axis = 0; axis < 3; ++axis) sum[axis] += corners_[k].weight * (corner[axis] - origin[axis]);
    }
    std::copy_n(sum, 3, integrals + 3 * p);
  }
}

void VertexTangents::compute_tangents(std::uint32_t begin, std::uint32_t end, const float* integrals,
                                      const float* normals, float* tangents) const {
  for (std::uint32_t v = begin; v < end; ++v) {
    const float* const n = normals + 3 * std::size_t(v);
    float t[3] = {};
    for (const std::uint32_t polygon : incident_.row(v))
      for (int axis = 0; axis < 3; ++axis) t[axis] += integrals[3 * std::size_t(polygon) + axis];
    const float along = (t[0] * n[0] + t[1] * n[1]) + t[2] * n[2];
    for (int axis = 0; axis < 3; ++axis) t[axis] -= along * n[axis];
    const bool has_normal = n[0] != 0 || n[1] != 0 || n[2] != 0;
    const float size = std::max(std::max(std::fabs(t[0]), std::fabs(t[1])), std::fabs(t[2]));
    const bool finite = t[0] - t[0] == 0 && t[1] - t[1] == 0 && t[2] - t[2] == 0;
    const bool has_tangent = has_normal && finite && size > 0;
    for (float& x : t) x = has_tangent ? x / size : 0;  // so that squares neither overflow nor underflow
    const float length = has_tangent ? std::sqrt((t[0] * t[0] + t[1] * t[1]) + t[2] * t[2]) : 1;
    for (int axis = 0; axis < 3; ++axis) tangents[3 * std::size_t(v) + axis] = t[axis] / length;
  }
}

void VertexTangents::run(const float* rows, const VertexNormals& normals, const VertexNormals::State& normals_state,
                         State& state) const {
  const auto moved = normals_state.moved();
  if (std::any_of(moved.begin(), moved.end(), [](std::uint8_t m) { return m != 0; }))
    compute_integrals(rows, state.integrals_.data());
  for (std::size_t b = 0; b < block_count_; ++b) {
    const bool was_moved = state.moved_[b] != 0;
    state.moved_[b] = moved[b];
    const auto [begin, end] = normals.vertices_of(b);
    if (state.moved_[b])
      compute_tangents(begin, end, state.integrals_.data(), normals_state.normals(), state.tangents_.data());
    else if (was_moved)
      std::copy(at_rest_.begin() + 3 * std::ptrdiff_t(begin), at_rest_.begin() + 3 * std::ptrdiff_t(end),
                state.tangents_.begin() + 3 * std::ptrdiff_t(begin));
  }
}

}  // namespace fb::runtime
