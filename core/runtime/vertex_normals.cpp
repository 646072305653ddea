#include "runtime/vertex_normals.h"

#include <algorithm>
#include <cstring>

#include "base/checked.h"
#include "runtime/float_state.h"
#include "runtime/grouped.h"

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

Vector turned(Vector v) {
  return __builtin_shufflevector(v, v, 1, 2, 0, 3);
}

// Of polygons beyond this, which only strange meshes have, it is not looked up which chunks they reach.
constexpr std::uint32_t most_influences = 64;

// The cross product's z, x and y; what is in the fourth place means nothing.
Vector turned_cross(Vector a, Vector b) {
  return a * turned(b) - turned(a) * b;
}

}  // namespace

VertexNormals::State::State(const VertexNormals& normals, std::pmr::memory_resource& memory)
    : areas_(4 * (normals.polygons_.size() + 1), &memory),
      normals_(normals.at_rest_.begin(), normals.at_rest_.end(), &memory),
      moved_(normals.chunk_count(), &memory),
      needed_(normals.chunk_count(), &memory) {
  normals_.push_back(0);
}

VertexNormals::VertexNormals(const Mesh& mesh, std::span<const std::uint32_t> place_of,
                             std::span<const std::uint32_t> chunk_rows, std::pmr::memory_resource& memory)
    : polygons_(&memory),
      polygon_begin_(&memory),
      larger_(&memory),
      larger_begin_(&memory),
      around_(&memory),
      beyond_(&memory),
      beyond_begin_(&memory),
      vertex_begin_(&memory),
      sources_(&memory),
      source_begin_(&memory),
      influences_(&memory),
      influence_begin_(&memory),
      unpredictable_(chunk_rows.size() - 1, &memory),
      at_rest_(mesh.points.size(), &memory) {
  const std::size_t chunks = chunk_rows.size() - 1, vertices = mesh.vertex_count();
  for (const std::uint32_t row : chunk_rows) vertex_begin_.push_back((row + 2) / 3);
  // Of each vertex, in baked order, the chunk of its first row and that of its last: it may lie in two.
  std::vector<std::uint32_t> owner(vertices), last(vertices);
  for (std::uint32_t v = 0, chunk = 0; v < vertices; ++v) {
    while (3 * v >= chunk_rows[chunk + 1]) ++chunk;
    owner[v] = last[v] = chunk;
    while (3 * v + 2 >= chunk_rows[last[v] + 1]) ++last[v];
  }

  std::vector<std::uint32_t> corners = mesh.polygon_corners;
  if (!place_of.empty())
    for (std::uint32_t& corner : corners) corner = place_of[corner];
  struct Polygon {
    std::uint32_t first_corner, size;
  };
  Grouped<Polygon> by_chunk(chunks);
  std::uint32_t first_corner = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) {
    by_chunk.add(owner[corners[first_corner]], {first_corner, size});
    first_corner += size;
  }
  std::pmr::vector<Polygon> polygons;
  std::pmr::vector<std::uint32_t> polygon_begin;
  by_chunk.move_to(polygons, polygon_begin);

  Grouped<std::uint32_t> by_vertex(vertices);
  std::vector<std::vector<std::uint32_t>> sources(chunks), influences(chunks);
  const auto note = [](std::vector<std::uint32_t>& list, std::uint32_t chunk) {
    if (list.empty() || list.back() != chunk) list.push_back(chunk);
  };
  for (std::uint32_t v = 0; v < vertices; ++v)
    for (const std::uint32_t chunk : {owner[v], last[v]}) note(influences[owner[v]], chunk);
  std::vector<std::uint32_t> seen(vertices, UINT32_MAX);  // the last polygon of a vertex: it counts once there
  std::vector<std::uint32_t> reached;                     // the chunks a polygon's corners lie in
  polygons_.reserve(polygons.size());
  for (std::uint32_t chunk = 0; chunk < chunks; ++chunk) {
    polygon_begin_.push_back(static_cast<std::uint32_t>(polygons_.size()));
    larger_begin_.push_back(static_cast<std::uint32_t>(larger_.size()));
    for (std::uint32_t p = polygon_begin[chunk]; p < polygon_begin[chunk + 1]; ++p) {
      const std::uint32_t size = polygons[p].size, *corner = corners.data() + polygons[p].first_corner;
      const auto quad = [&](std::uint32_t k) {
        return Quad{{corner[0], corner[k], corner[k + 1], k + 2 < size ? corner[k + 2] : corner[0]}};
      };
      polygons_.push_back(quad(1));
      for (std::uint32_t k = 3; k + 1 < size; k += 2) larger_.push_back({p, quad(k)});
      reached.clear();
      for (std::uint32_t k = 0; k < size; ++k) {
        const std::uint32_t v = corner[k];
        note(reached, owner[v]);
        note(reached, last[v]);
        if (seen[v] == p) continue;
        seen[v] = p;
        by_vertex.add(v, p);
        note(sources[owner[v]], chunk);
      }
      for (std::uint32_t k = 0; k < size; ++k) {
        const std::uint32_t to = owner[corner[k]];
        if (k > 0 && to == owner[corner[k - 1]]) continue;
        if (size > most_influences)
          unpredictable_[to] = 1;
        else
          for (const std::uint32_t c : reached) note(influences[to], c);
      }
    }
  }
  polygon_begin_.push_back(static_cast<std::uint32_t>(polygons_.size()));
  larger_begin_.push_back(checked_u32(larger_.size(), "the corners of large polygons"));
  std::pmr::vector<std::uint32_t> around, around_begin;
  by_vertex.move_to(around, around_begin);
  around_.reserve(vertices);
  for (std::uint32_t v = 0, chunk = 0; v < vertices; ++v) {
    for (; v >= vertex_begin_[chunk]; ++chunk) beyond_begin_.push_back(static_cast<std::uint32_t>(beyond_.size()));
    Around& first = around_.emplace_back();
    std::fill_n(first.polygon, 4, static_cast<std::uint32_t>(polygons_.size()));
    for (std::uint32_t a = around_begin[v], k = 0; a < around_begin[v + 1]; ++a, ++k)
      if (k < 4)
        first.polygon[k] = around[a];
      else
        beyond_.push_back({v, around[a]});
  }
  beyond_begin_.resize(chunks + 1, checked_u32(beyond_.size(), "the polygons around vertices"));
  const auto flatten = [&](std::vector<std::vector<std::uint32_t>>& lists, std::pmr::vector<std::uint32_t>& items,
                           std::pmr::vector<std::uint32_t>& begin) {
    for (std::vector<std::uint32_t>& list : lists) {
      begin.push_back(static_cast<std::uint32_t>(items.size()));
      std::sort(list.begin(), list.end());
      items.insert(items.end(), list.begin(), std::unique(list.begin(), list.end()));
    }
    begin.push_back(checked_u32(items.size(), "the neighbours of all row groups"));
  };
  flatten(sources, sources_, source_begin_);
  flatten(influences, influences_, influence_begin_);

  std::vector<float> rows(mesh.points.size() + 1);
  for (std::size_t v = 0; v < vertices; ++v)
    std::copy_n(mesh.points.begin() + 3 * v, 3, rows.begin() + 3 * (place_of.empty() ? v : place_of[v]));
  std::vector<float> areas(4 * (polygons_.size() + 1));
  const FloatState state;
  for (std::size_t c = 0; c < chunks; ++c) compute_areas(c, rows.data(), areas.data());
  for (std::size_t c = 0; c < chunks; ++c) compute_normals(scalar_kernels, c, areas.data(), at_rest_.data());
}

[[gnu::noinline]] void VertexNormals::compute_areas(std::size_t chunk, const float* rows, float* areas) const {
  const auto area_of = [&](const Quad& quad) {
    const auto at = [&](int k) { return load(rows + 3 * std::size_t(quad.corner[k])); };
    return turned_cross(at(2) - at(0), at(3) - at(1));
  };
  for (std::uint32_t p = polygon_begin_[chunk]; p < polygon_begin_[chunk + 1]; ++p)
    store(areas + 4 * std::size_t(p), area_of(polygons_[p]));
  for (std::uint32_t l = larger_begin_[chunk]; l < larger_begin_[chunk + 1]; ++l) {
    float* area = areas + 4 * std::size_t(larger_[l].polygon);
    store(area, load(area) + area_of(larger_[l].quad));
  }
}

// Without a branch on how many polygons a vertex has: most have four, and which do not cannot be predicted.
[[gnu::noinline]] void VertexNormals::compute_normals(const PoseKernels& kernels, std::size_t chunk, const float* areas,
                                                      float* normals) const {
  constexpr std::uint32_t most = 64;
  const std::uint32_t end = vertex_begin_[chunk + 1];
  const Beyond* beyond = beyond_.data() + beyond_begin_[chunk];
  const Beyond* const beyond_end = beyond_.data() + beyond_begin_[chunk + 1];
  for (std::uint32_t first = vertex_begin_[chunk]; first < end; first += most) {
    const std::uint32_t count = std::min(most, end - first);
    Vector sums[most];
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t* polygon = around_[first + i].polygon;
      const auto area = [&](int k) { return load(areas + 4 * std::size_t(polygon[k])); };
      sums[i] = ((area(0) + area(1)) + area(2)) + area(3);
    }
    for (; beyond < beyond_end && beyond->vertex < first + count; ++beyond)
      sums[beyond->vertex - first] += load(areas + 4 * std::size_t(beyond->polygon));
    for (std::uint32_t i = count; i < most; ++i) sums[i] = Vector{};
    float x[most], y[most], z[most];
    for (std::uint32_t i = 0; i < most; i += 4) {
      const Vector zx01 = __builtin_shufflevector(sums[i], sums[i + 1], 0, 4, 1, 5);
      const Vector zx23 = __builtin_shufflevector(sums[i + 2], sums[i + 3], 0, 4, 1, 5);
      const Vector y01 = __builtin_shufflevector(sums[i], sums[i + 1], 2, 6, 2, 6);
      const Vector y23 = __builtin_shufflevector(sums[i + 2], sums[i + 3], 2, 6, 2, 6);
      store(z + i, __builtin_shufflevector(zx01, zx23, 0, 1, 4, 5));
      store(x + i, __builtin_shufflevector(zx01, zx23, 2, 3, 6, 7));
      store(y + i, __builtin_shufflevector(y01, y23, 0, 1, 4, 5));
    }
    kernels.normalise(x, y, z, most);
    float* to = normals + 3 * std::size_t(first);
    for (std::uint32_t i = 0; i < count; ++i, to += 3) to[0] = x[i], to[1] = y[i], to[2] = z[i];
  }
}

void VertexNormals::run(const PoseKernels& kernels, const float* rows, std::span<const std::uint8_t> moved,
                        State& state) const {
  const auto marked = [&](std::size_t chunk) {
    return unpredictable_[chunk] ||
           std::any_of(influences_.begin() + influence_begin_[chunk], influences_.begin() + influence_begin_[chunk + 1],
                       [&](std::uint32_t c) { return moved[c] != 0; });
  };
  std::fill(state.needed_.begin(), state.needed_.end(), std::uint8_t(0));
  for (std::size_t c = 0; c < chunk_count(); ++c) {
    const bool was = state.moved_[c] != 0;
    state.moved_[c] = marked(c);
    if (state.moved_[c]) {
      for (std::uint32_t s = source_begin_[c]; s < source_begin_[c + 1]; ++s) state.needed_[sources_[s]] = 1;
    } else if (was) {
      std::copy(at_rest_.begin() + 3 * std::size_t(vertex_begin_[c]),
                at_rest_.begin() + 3 * std::size_t(vertex_begin_[c + 1]),
                state.normals_.begin() + 3 * std::size_t(vertex_begin_[c]));
    }
  }
  for (std::size_t c = 0; c < chunk_count(); ++c)
    if (state.needed_[c]) compute_areas(c, rows, state.areas_.data());
  for (std::size_t c = 0; c < chunk_count(); ++c)
    if (state.moved_[c]) compute_normals(kernels, c, state.areas_.data(), state.normals_.data());
}

}  // namespace fb::runtime
