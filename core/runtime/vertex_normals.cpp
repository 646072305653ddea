#include "runtime/vertex_normals.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/checked.h"
#include "model/mesh_scale.h"
#include "runtime/float_mode.h"

namespace fb::runtime {
namespace {

using Vector = float __attribute__((vector_size(16)));

Vector load(const float* from) {
  Vector v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

void store(float* to, Vector v) {
  std::memcpy(to, &v, sizeof v);
}

Vector rotated(Vector v) {
  return __builtin_shufflevector(v, v, 1, 2, 0, 3);
}

// The z, x and y of the cross product; the fourth lane is undefined.
Vector rotated_cross(Vector a, Vector b) {
  return a * rotated(b) - rotated(a) * b;
}

// Polygons with more corners, which are rare, have no dependencies listed; the cost of listing is quadratic.
constexpr std::uint32_t max_tracked_corners = 64;

void add_block(std::pmr::vector<std::uint32_t>& list, std::uint32_t block) {
  if (list.empty() || list.back() != block) list.push_back(block);
}

using BlockLists = std::pmr::vector<std::pmr::vector<std::uint32_t>>;

// Sorted, without duplicates.
void fill_table(BlockLists& lists, CsrTable<std::uint32_t>& table) {
  for (std::pmr::vector<std::uint32_t>& list : lists) {
    table.row_offsets.push_back(static_cast<std::uint32_t>(table.entries.size()));
    std::sort(list.begin(), list.end());
    table.entries.insert(table.entries.end(), list.begin(), std::unique(list.begin(), list.end()));
  }
  table.row_offsets.push_back(checked_u32(table.entries.size(), "the neighbours of all row blocks"));
}

}  // namespace

// The row block of each vertex' first and last row: a vertex may lie in two.
struct VertexNormals::Blocks {
  Blocks(std::size_t vertices, std::span<const std::uint32_t> block_rows, std::pmr::memory_resource& heap)
      : first(vertices, &heap), last(vertices, &heap) {
    for (std::uint32_t v = 0, block = 0; v < vertices; ++v) {
      while (3 * v >= block_rows[block + 1]) ++block;
      first[v] = last[v] = block;
      while (3 * v + 2 >= block_rows[last[v] + 1]) ++last[v];
    }
  }
  std::pmr::vector<std::uint32_t> first, last;
};

CsrTable<VertexNormals::Polygon> VertexNormals::polygons_by_block(const Mesh& mesh,
                                                                  std::span<const std::uint32_t> corners,
                                                                  const Blocks& blocks, std::size_t block_count,
                                                                  std::pmr::memory_resource& heap) {
  CsrBuilder<Polygon> by_block(block_count, mesh.polygon_sizes.size(), heap);
  std::uint32_t first_corner = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) {
    by_block.add(blocks.first[corners[first_corner]], {first_corner, size});
    first_corner += size;
  }
  CsrTable<Polygon> polygons(heap);
  by_block.build(polygons);
  return polygons;
}

VertexNormals::State::State(const VertexNormals& normals, std::pmr::memory_resource& memory)
    : areas_(4 * (normals.polygons_.size() + 1), &memory),
      normals_(normals.at_rest_.begin(), normals.at_rest_.end(), &memory),
      moved_(normals.block_count(), &memory),
      needed_(normals.block_count(), &memory) {
  normals_.push_back(0);
}

VertexNormals::VertexNormals(const Mesh& mesh, std::span<const std::uint32_t> baked_index,
                             std::span<const std::uint32_t> block_rows, std::pmr::memory_resource& memory,
                             std::pmr::memory_resource& heap)
    : polygons_(&memory),
      polygon_offsets_(&memory),
      fan_quads_(&memory),
      fan_offsets_(&memory),
      first_polygons_(&memory),
      extra_polygons_(&memory),
      extra_offsets_(&memory),
      vertex_offsets_(&memory),
      polygon_blocks_(memory),
      dependencies_(memory),
      always_moved_(block_rows.size() - 1, &memory),
      at_rest_(mesh.points.size(), &memory),
      scale_(std::ldexp(1.0f, std::clamp(scale_exponent(mesh), -126, 126))) {
  vertex_offsets_.reserve(block_rows.size());
  for (const std::uint32_t row : block_rows) vertex_offsets_.push_back((row + 2) / 3);
  const Blocks blocks(mesh.vertex_count(), block_rows, heap);
  std::pmr::vector<std::uint32_t> corners(mesh.polygon_corners.begin(), mesh.polygon_corners.end(), &heap);
  if (!baked_index.empty())
    for (std::uint32_t& corner : corners) corner = baked_index[corner];
  CsrTable<std::uint32_t> incident(heap);
  {
    CsrBuilder<std::uint32_t> at_vertex(mesh.vertex_count(), corners.size(), heap);
    add_polygons(polygons_by_block(mesh, corners, blocks, block_count(), heap), corners, blocks, at_vertex, heap);
    at_vertex.build(incident);
  }
  add_incident_polygons(incident);
  with_float_mode([&] { compute_rest(mesh, baked_index, heap); });
}

void VertexNormals::add_polygons(const CsrTable<Polygon>& polygons, std::span<const std::uint32_t> corners,
                                 const Blocks& blocks, CsrBuilder<std::uint32_t>& at_vertex,
                                 std::pmr::memory_resource& heap) {
  BlockLists polygon_blocks(block_count(), &heap), dependencies(block_count(), &heap);
  for (std::size_t v = 0; v < blocks.first.size(); ++v)
    for (const std::uint32_t block : {blocks.first[v], blocks.last[v]}) add_block(dependencies[blocks.first[v]], block);
  // By vertex: a polygon counts once there.
  std::pmr::vector<std::uint32_t> last_polygon(blocks.first.size(), UINT32_MAX, &heap);
  std::pmr::vector<std::uint32_t> reached(&heap);  // the row blocks of a polygon's corners
  polygons_.reserve(polygons.entries.size());
  for (std::uint32_t block = 0; block < block_count(); ++block) {
    polygon_offsets_.push_back(static_cast<std::uint32_t>(polygons_.size()));
    fan_offsets_.push_back(static_cast<std::uint32_t>(fan_quads_.size()));
    for (const Polygon& polygon : polygons.row(block)) {
      const std::uint32_t size = polygon.size, *corner = corners.data() + polygon.first_corner;
      const auto p = static_cast<std::uint32_t>(polygons_.size());
      const auto quad = [&](std::uint32_t k) {
        return Quad{{corner[0], corner[k], corner[k + 1], k + 2 < size ? corner[k + 2] : corner[0]}};
      };
      polygons_.push_back(quad(1));
      for (std::uint32_t k = 3; k + 1 < size; k += 2) fan_quads_.push_back({p, quad(k)});
      reached.clear();
      for (std::uint32_t k = 0; k < size; ++k) {
        const std::uint32_t v = corner[k];
        add_block(reached, blocks.first[v]);
        add_block(reached, blocks.last[v]);
        if (last_polygon[v] == p) continue;
        last_polygon[v] = p;
        at_vertex.add(v, p);
        add_block(polygon_blocks[blocks.first[v]], block);
      }
      for (std::uint32_t k = 0; k < size; ++k) {
        const std::uint32_t to = blocks.first[corner[k]];
        if (k > 0 && to == blocks.first[corner[k - 1]]) continue;
        if (size > max_tracked_corners)
          always_moved_[to] = 1;
        else
          for (const std::uint32_t b : reached) add_block(dependencies[to], b);
      }
    }
  }
  polygon_offsets_.push_back(static_cast<std::uint32_t>(polygons_.size()));
  fan_offsets_.push_back(checked_u32(fan_quads_.size(), "the corners of large polygons"));
  fill_table(polygon_blocks, polygon_blocks_);
  fill_table(dependencies, dependencies_);
}

void VertexNormals::add_incident_polygons(const CsrTable<std::uint32_t>& at_vertex) {
  const auto vertices = static_cast<std::uint32_t>(at_rest_.size() / 3);
  first_polygons_.reserve(vertices);
  for (std::uint32_t v = 0, block = 0; v < vertices; ++v) {
    for (; v >= vertex_offsets_[block]; ++block)
      extra_offsets_.push_back(static_cast<std::uint32_t>(extra_polygons_.size()));
    FirstPolygons& first = first_polygons_.emplace_back();
    std::fill_n(first.polygon, 4, static_cast<std::uint32_t>(polygons_.size()));
    const std::span<const std::uint32_t> polygons = at_vertex.row(v);
    for (std::size_t k = 0; k < polygons.size(); ++k)
      if (k < 4)
        first.polygon[k] = polygons[k];
      else
        extra_polygons_.push_back({v, polygons[k]});
  }
  extra_offsets_.resize(block_count() + 1, checked_u32(extra_polygons_.size(), "the polygons around vertices"));
}

void VertexNormals::compute_rest(const Mesh& mesh, std::span<const std::uint32_t> baked_index,
                                 std::pmr::memory_resource& heap) {
  std::pmr::vector<float> rows(mesh.points.size() + 1, &heap);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
    std::copy_n(mesh.points.begin() + 3 * v, 3, rows.begin() + 3 * (baked_index.empty() ? v : baked_index[v]));
  std::pmr::vector<float> areas(4 * (polygons_.size() + 1), &heap);
  for (std::size_t b = 0; b < block_count(); ++b) compute_areas(b, rows.data(), areas.data());
  for (std::size_t b = 0; b < block_count(); ++b) compute_normals(scalar_kernels, b, areas.data(), at_rest_.data());
}

void VertexNormals::compute_areas(std::size_t block, const float* rows, float* areas) const {
  const auto compute = [&](auto&& distance) {
    const auto area_of = [&](const Quad& quad) {
      const auto at = [&](int k) { return load(rows + 3 * std::size_t(quad.corner[k])); };
      return rotated_cross(distance(at(2), at(0)), distance(at(3), at(1)));
    };
    for (std::uint32_t p = polygon_offsets_[block]; p < polygon_offsets_[block + 1]; ++p)
      store(areas + 4 * std::size_t(p), area_of(polygons_[p]));
    for (std::uint32_t f = fan_offsets_[block]; f < fan_offsets_[block + 1]; ++f) {
      float* area = areas + 4 * std::size_t(fan_quads_[f].polygon);
      store(area, load(area) + area_of(fan_quads_[f].quad));
    }
  };
  if (scale_ == 1)
    compute([](Vector a, Vector b) { return a - b; });
  else
    compute([&](Vector a, Vector b) { return (a - b) * scale_; });
}

// Always adds four polygons a vertex: most vertices have four, and a branch on the count would be unpredictable.
void VertexNormals::compute_normals(const PoseKernels& kernels, std::size_t block, const float* areas,
                                    float* normals) const {
  constexpr std::uint32_t batch = 64;
  const std::uint32_t end = vertex_offsets_[block + 1];
  const ExtraPolygon* extra = extra_polygons_.data() + extra_offsets_[block];
  const ExtraPolygon* const extra_end = extra_polygons_.data() + extra_offsets_[block + 1];
  for (std::uint32_t first = vertex_offsets_[block]; first < end; first += batch) {
    const std::uint32_t count = std::min(batch, end - first);
    Vector sums[batch];
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t* polygon = first_polygons_[first + i].polygon;
      const auto area = [&](int k) { return load(areas + 4 * std::size_t(polygon[k])); };
      sums[i] = ((area(0) + area(1)) + area(2)) + area(3);
    }
    for (; extra < extra_end && extra->vertex < first + count; ++extra)
      sums[extra->vertex - first] += load(areas + 4 * std::size_t(extra->polygon));
    for (std::uint32_t i = count; i < batch; ++i) sums[i] = Vector{};
    float x[batch], y[batch], z[batch];
    for (std::uint32_t i = 0; i < batch; i += 4) {
      const Vector zx01 = __builtin_shufflevector(sums[i], sums[i + 1], 0, 4, 1, 5);
      const Vector zx23 = __builtin_shufflevector(sums[i + 2], sums[i + 3], 0, 4, 1, 5);
      const Vector y01 = __builtin_shufflevector(sums[i], sums[i + 1], 2, 6, 2, 6);
      const Vector y23 = __builtin_shufflevector(sums[i + 2], sums[i + 3], 2, 6, 2, 6);
      store(z + i, __builtin_shufflevector(zx01, zx23, 0, 1, 4, 5));
      store(x + i, __builtin_shufflevector(zx01, zx23, 2, 3, 6, 7));
      store(y + i, __builtin_shufflevector(y01, y23, 0, 1, 4, 5));
    }
    kernels.normalise(x, y, z, batch);
    float* to = normals + 3 * std::size_t(first);
    for (std::uint32_t i = 0; i < count; ++i, to += 3) to[0] = x[i], to[1] = y[i], to[2] = z[i];
  }
}

void VertexNormals::run(const PoseKernels& kernels, const float* rows, std::span<const std::uint8_t> moved,
                        State& state) const {
  const auto can_move = [&](std::size_t block) {
    const std::span<const std::uint32_t> blocks = dependencies_.row(block);
    return always_moved_[block] ||
           std::any_of(blocks.begin(), blocks.end(), [&](std::uint32_t b) { return moved[b] != 0; });
  };
  std::fill(state.needed_.begin(), state.needed_.end(), std::uint8_t(0));
  for (std::size_t b = 0; b < block_count(); ++b) {
    const bool was_moved = state.moved_[b] != 0;
    state.moved_[b] = can_move(b);
    if (state.moved_[b]) {
      for (const std::uint32_t source : polygon_blocks_.row(b)) state.needed_[source] = 1;
    } else if (was_moved) {
      std::copy(at_rest_.begin() + 3 * std::size_t(vertex_offsets_[b]),
                at_rest_.begin() + 3 * std::size_t(vertex_offsets_[b + 1]),
                state.normals_.begin() + 3 * std::size_t(vertex_offsets_[b]));
    }
  }
  for (std::size_t b = 0; b < block_count(); ++b)
    if (state.needed_[b]) compute_areas(b, rows, state.areas_.data());
  for (std::size_t b = 0; b < block_count(); ++b)
    if (state.moved_[b]) compute_normals(kernels, b, state.areas_.data(), state.normals_.data());
}

}  // namespace fb::runtime
