#include "runtime/vertex_tangents.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"
#include "runtime/float_state.h"
#include "runtime/grouped.h"

namespace fb::runtime {

VertexTangents::State::State(const VertexTangents& tangents, std::pmr::memory_resource& memory)
    : polygons_(3 * tangents.polygon_begin_.size(), &memory),
      tangents_(tangents.at_rest_.begin(), tangents.at_rest_.end(), &memory),
      moved_(tangents.chunks_, &memory) {
  if (!tangents_.empty()) tangents_.push_back(0);
}

VertexTangents::VertexTangents(const Mesh& mesh, std::span<const std::uint32_t> place_of, const VertexNormals& normals,
                               std::pmr::memory_resource& memory)
    : corners_(&memory),
      polygon_begin_(&memory),
      around_(&memory),
      around_begin_(&memory),
      signs_(&memory),
      at_rest_(&memory),
      chunks_(normals.chunk_count()) {
  if (mesh.uvs.empty()) return;
  const std::size_t vertices = mesh.vertex_count();
  const auto place = [&](std::uint32_t vertex) { return place_of.empty() ? vertex : place_of[vertex]; };
  std::vector<double> areas(vertices);
  Grouped<std::uint32_t> by_vertex(vertices);
  const FloatState state;
  std::size_t first = 0;
  for (std::uint32_t p = 0; p < mesh.polygon_sizes.size(); ++p) {
    const std::uint32_t size = mesh.polygon_sizes[p];
    const auto uv = [&](std::uint32_t k, int axis) {
      return double(mesh.uvs[2 * std::size_t(mesh.uv_corners[first + k % size]) + axis]);
    };
    double area = 0;  // of the polygon in the picture, twice
    for (std::uint32_t k = 0; k < size; ++k) area += uv(k, 0) * uv(k + 1, 1) - uv(k + 1, 0) * uv(k, 1);
    const double side = area > 0 ? 1 : area < 0 ? -1 : 0;
    polygon_begin_.push_back(checked_u32(corners_.size(), "polygon corners"));
    for (std::uint32_t k = 0; k < size; ++k) {
      const std::uint32_t vertex = mesh.polygon_corners[first + k];
      corners_.push_back({place(vertex), static_cast<float>(side * (uv(k + 1, 1) - uv(k + size - 1, 1)))});
      by_vertex.add(place(vertex), p);
      areas[vertex] += area;
    }
    first += size;
  }
  polygon_begin_.push_back(checked_u32(corners_.size(), "polygon corners"));
  by_vertex.move_to(around_, around_begin_);
  for (const double area : areas) signs_.push_back(area < 0 ? -1.0f : 1.0f);

  std::vector<float> rows(3 * vertices), polygons(3 * polygon_begin_.size());
  for (std::size_t v = 0; v < vertices; ++v)
    std::copy_n(mesh.points.begin() + 3 * v, 3, rows.begin() + 3 * place(static_cast<std::uint32_t>(v)));
  at_rest_.resize(3 * vertices);
  compute_polygons(rows.data(), polygons.data());
  compute_tangents(0, static_cast<std::uint32_t>(vertices), polygons.data(), normals.at_rest().data(), at_rest_.data());
}

[[gnu::noinline]] void VertexTangents::compute_polygons(const float* rows, float* polygons) const {
  for (std::size_t p = 0; p + 1 < polygon_begin_.size(); ++p) {
    const float* const origin = rows + 3 * std::size_t(corners_[polygon_begin_[p]].place);
    float sum[3] = {};
    for (std::uint32_t k = polygon_begin_[p] + 1; k < polygon_begin_[p + 1]; ++k) {
      const float* const corner = rows + 3 * std::size_t(corners_[k].place);
      for (int axis = 0; axis < 3; ++axis) sum[axis] += corners_[k].weight * (corner[axis] - origin[axis]);
    }
    std::copy_n(sum, 3, polygons + 3 * p);
  }
}

[[gnu::noinline]] void VertexTangents::compute_tangents(std::uint32_t begin, std::uint32_t end, const float* polygons,
                                                        const float* normals, float* tangents) const {
  for (std::uint32_t v = begin; v < end; ++v) {
    const float* const n = normals + 3 * std::size_t(v);
    float t[3] = {};
    for (std::uint32_t a = around_begin_[v]; a < around_begin_[v + 1]; ++a)
      for (int axis = 0; axis < 3; ++axis) t[axis] += polygons[3 * std::size_t(around_[a]) + axis];
    const float along = (t[0] * n[0] + t[1] * n[1]) + t[2] * n[2];
    for (int axis = 0; axis < 3; ++axis) t[axis] -= along * n[axis];
    const bool has_normal = n[0] != 0 || n[1] != 0 || n[2] != 0;
    const float size = std::max(std::max(std::fabs(t[0]), std::fabs(t[1])), std::fabs(t[2]));
    const bool finite = t[0] - t[0] == 0 && t[1] - t[1] == 0 && t[2] - t[2] == 0;
    const bool has_tangent = has_normal && finite && size > 0;
    for (float& x : t) x = has_tangent ? x / size : 0;  // so that squares neither overflow nor vanish
    const float length = has_tangent ? std::sqrt((t[0] * t[0] + t[1] * t[1]) + t[2] * t[2]) : 1;
    for (int axis = 0; axis < 3; ++axis) tangents[3 * std::size_t(v) + axis] = t[axis] / length;
  }
}

void VertexTangents::run(const float* rows, const VertexNormals& normals, const VertexNormals::State& normals_state,
                         State& state) const {
  const auto moved = normals_state.moved();
  if (std::any_of(moved.begin(), moved.end(), [](std::uint8_t m) { return m != 0; }))
    compute_polygons(rows, state.polygons_.data());
  for (std::size_t c = 0; c < chunks_; ++c) {
    const bool was = state.moved_[c] != 0;
    state.moved_[c] = moved[c];
    const auto [begin, end] = normals.vertices_of(c);
    if (state.moved_[c])
      compute_tangents(begin, end, state.polygons_.data(), normals_state.normals(), state.tangents_.data());
    else if (was)
      std::copy(at_rest_.begin() + 3 * std::ptrdiff_t(begin), at_rest_.begin() + 3 * std::ptrdiff_t(end),
                state.tangents_.begin() + 3 * std::ptrdiff_t(begin));
  }
}

}  // namespace fb::runtime
