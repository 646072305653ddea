#include "runtime/vertex_normals.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <set>

#include "runtime/float_state.h"
#include "runtime/grouped.h"

namespace fb {
namespace {

using Vector = float __attribute__((vector_size(16)));

Vector load(const float* from) {
  Vector v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

Vector turned(Vector v) {
  return __builtin_shufflevector(v, v, 1, 2, 0, 3);
}

// The cross product's z, x and y; what is in the fourth place means nothing.
Vector turned_cross(Vector a, Vector b) {
  return a * turned(b) - turned(a) * b;
}

}  // namespace

VertexNormals::State::State(const VertexNormals& normals, std::pmr::memory_resource& memory)
    : areas_(4 * normals.pieces_.size(), &memory),
      normals_(normals.at_rest_.begin(), normals.at_rest_.end(), &memory),
      moved_(normals.chunk_count(), &memory),
      needed_(normals.chunk_count(), &memory) {
  normals_.push_back(0);
}

VertexNormals::VertexNormals(const Mesh& mesh, std::span<const std::uint32_t> place_of,
                             std::span<const std::uint32_t> chunk_rows, std::pmr::memory_resource& memory)
    : pieces_(&memory),
      piece_begin_(&memory),
      around_(&memory),
      around_begin_(&memory),
      vertex_begin_(&memory),
      sources_(&memory),
      source_begin_(&memory),
      influences_(&memory),
      influence_begin_(&memory),
      at_rest_(mesh.points.size(), &memory) {
  const std::size_t chunks = chunk_rows.size() - 1;
  for (const std::uint32_t row : chunk_rows) vertex_begin_.push_back((row + 2) / 3);
  const auto chunk_of = [&](std::uint32_t row) {
    return static_cast<std::uint32_t>(std::upper_bound(chunk_rows.begin(), chunk_rows.end(), row) - chunk_rows.begin() -
                                      1);
  };
  // A vertex' first and last row may be in two chunks.
  const auto owner = [&](std::uint32_t place) { return chunk_of(3 * place); };

  Grouped<Piece> by_chunk(chunks);
  Grouped<std::uint32_t> polygons_by_chunk(chunks);
  std::vector<std::vector<std::uint32_t>> corners;  // of each polygon, as places
  const std::uint32_t* corner = mesh.polygon_corners.data();
  for (const std::uint32_t size : mesh.polygon_sizes) {
    std::vector<std::uint32_t>& places = corners.emplace_back();
    for (std::uint32_t k = 0; k < size; ++k, ++corner) places.push_back(place_of.empty() ? *corner : place_of[*corner]);
    const std::uint32_t chunk = owner(places[0]);
    polygons_by_chunk.add(chunk, static_cast<std::uint32_t>(corners.size() - 1));
    for (std::uint32_t k = 1; k + 1 < size; k += 2)
      by_chunk.add(chunk, {{places[0], places[k], places[k + 1], k + 2 < size ? places[k + 2] : places[0]}});
  }
  by_chunk.move_to(pieces_, piece_begin_);

  // Pieces were laid out polygon after polygon within each chunk.
  std::pmr::vector<std::uint32_t> polygons, polygon_begin;
  polygons_by_chunk.move_to(polygons, polygon_begin);
  const std::size_t vertices = mesh.vertex_count();
  Grouped<std::uint32_t> by_vertex(vertices);
  std::vector<std::set<std::uint32_t>> sources(chunks), influences(chunks);
  for (std::uint32_t v = 0; v < vertices; ++v)
    for (const std::uint32_t row : {3 * v, 3 * v + 2}) influences[owner(v)].insert(chunk_of(row));
  std::uint32_t piece = 0;
  for (const std::uint32_t polygon : polygons) {
    const std::vector<std::uint32_t>& places = corners[polygon];
    const auto count = static_cast<std::uint32_t>((places.size() - 1) / 2);
    std::vector<std::uint32_t> once = places;
    std::sort(once.begin(), once.end());
    once.erase(std::unique(once.begin(), once.end()), once.end());
    for (const std::uint32_t v : once) {
      for (std::uint32_t p = piece; p < piece + count; ++p) by_vertex.add(v, p);
      sources[owner(v)].insert(owner(places[0]));
      for (const std::uint32_t other : once)
        for (const std::uint32_t row : {3 * other, 3 * other + 2}) influences[owner(v)].insert(chunk_of(row));
    }
    piece += count;
  }
  by_vertex.move_to(around_, around_begin_);
  Grouped<std::uint32_t> by_source(chunks), by_influence(chunks);
  for (std::size_t c = 0; c < chunks; ++c) {
    for (const std::uint32_t s : sources[c]) by_source.add(c, s);
    for (const std::uint32_t i : influences[c]) by_influence.add(c, i);
  }
  by_source.move_to(sources_, source_begin_);
  by_influence.move_to(influences_, influence_begin_);

  std::vector<float> rows(mesh.points.size() + 1);
  for (std::size_t v = 0; v < vertices; ++v)
    std::copy_n(mesh.points.begin() + 3 * v, 3, rows.begin() + 3 * (place_of.empty() ? v : place_of[v]));
  std::vector<float> areas(4 * pieces_.size());
  const FloatState state;
  for (std::size_t c = 0; c < chunks; ++c) compute_areas(c, rows.data(), areas.data());
  for (std::size_t c = 0; c < chunks; ++c) compute_normals(c, areas.data(), at_rest_.data());
}

[[gnu::noinline]] void VertexNormals::compute_areas(std::size_t chunk, const float* rows, float* areas) const {
  for (std::uint32_t p = piece_begin_[chunk]; p < piece_begin_[chunk + 1]; ++p) {
    const std::uint32_t* corner = pieces_[p].corner;
    const auto at = [&](int k) { return load(rows + 3 * std::size_t(corner[k])); };
    const Vector area = turned_cross(at(2) - at(0), at(3) - at(1));
    std::memcpy(areas + 4 * std::size_t(p), &area, sizeof area);
  }
}

[[gnu::noinline]] void VertexNormals::compute_normals(std::size_t chunk, const float* areas, float* normals) const {
  constexpr std::uint32_t most = 16;
  const std::uint32_t end = vertex_begin_[chunk + 1];
  for (std::uint32_t first = vertex_begin_[chunk]; first < end; first += most) {
    const std::uint32_t count = std::min(most, end - first);
    float x[most], y[most], z[most];
    for (std::uint32_t i = 0; i < count; ++i) {
      Vector sum = {};
      for (std::uint32_t a = around_begin_[first + i]; a < around_begin_[first + i + 1]; ++a)
        sum += load(areas + 4 * std::size_t(around_[a]));
      z[i] = sum[0], x[i] = sum[1], y[i] = sum[2];
    }
    for (std::uint32_t i = count; i < most; ++i) x[i] = y[i] = z[i] = 0;
    for (std::uint32_t i = 0; i < most; ++i) {
      const float square = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
      const bool sound = square > 0 && square <= FLT_MAX;
      const float scale = 1 / std::sqrt(square);
      x[i] = sound ? x[i] * scale : 0, y[i] = sound ? y[i] * scale : 0, z[i] = sound ? z[i] * scale : 0;
    }
    float* to = normals + 3 * std::size_t(first);
    for (std::uint32_t i = 0; i < count; ++i, to += 3) to[0] = x[i], to[1] = y[i], to[2] = z[i];
  }
}

void VertexNormals::run(const float* rows, std::span<const std::uint8_t> moved, State& state) const {
  const auto marked = [&](std::size_t chunk) {
    return std::any_of(influences_.begin() + influence_begin_[chunk], influences_.begin() + influence_begin_[chunk + 1],
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
    if (state.moved_[c]) compute_normals(c, state.areas_.data(), state.normals_.data());
}

}  // namespace fb
