// Coding of polygon corners, shared by reader and writer: as differences from an earlier corner, or along the triangles
// of section "geometry", where the first edge of a polygon determines its other corners. See FORMAT.md, "polygons".
#pragma once

#include <array>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

namespace fb::archive {

// The prediction of corner k of a polygon, at index `at` of all corners: corner k of the previous polygon, which has
// `previous_size` corners, or else the corner before it.
inline std::uint32_t predicted_corner(std::span<const std::uint32_t> corners, std::size_t at, std::uint32_t k,
                                      std::uint32_t previous_size) {
  if (k < previous_size) return corners[at - previous_size];
  return at > 0 ? corners[at - 1] : 0;
}

// The zigzag differences of corners from their predictions, of polygons of these sizes. Those of neighbouring polygons
// are small and alike.
std::vector<std::uint32_t> corner_deltas(const std::vector<std::uint32_t>& sizes,
                                         const std::vector<std::uint32_t>& corners);
// Its inverse, in place.
void restore_corners(std::span<const std::uint32_t> sizes, std::span<std::uint32_t> deltas);

// The half-edges of triangles, by the vertex they start from.
class TriangleEdges {
 public:
  struct Edge {
    std::uint32_t to = 0, opposite = 0;  // the vertex it leads to, and the triangle's third
  };

  // Corners are below `vertices`, three a triangle.
  TriangleEdges(const std::vector<std::uint32_t>& triangles, std::uint32_t vertices,
                std::pmr::memory_resource& memory = *std::pmr::get_default_resource());

  std::span<const Edge> from(std::uint32_t vertex) const {
    return {edges_.data() + first_[vertex], edges_.data() + first_[vertex + 1]};
  }

 private:
  std::pmr::vector<std::uint32_t> first_;  // per vertex, its first edge; and the number of edges
  std::pmr::vector<Edge> edges_;
};

inline constexpr std::size_t max_edges = 64;
inline constexpr std::size_t max_fan_corners = max_edges + 2;  // of a polygon along triangles
using SortedEdges = std::array<TriangleEdges::Edge, max_edges>;
// The edges from a vertex, in `room`, sorted by the zigzag distance of their end from `prediction`. Empty if two edges
// end at one vertex or there are more than max_edges: polygons cannot be coded along these.
std::span<const TriangleEdges::Edge> sorted_edges(const TriangleEdges& edges, std::uint32_t vertex,
                                                  std::uint32_t prediction, SortedEdges& room);

// The prediction of a polygon's second corner: the same distance from the first as in the previous polygon.
inline std::uint32_t predicted_second_corner(std::span<const std::uint32_t> previous_polygon, std::uint32_t first) {
  return previous_polygon.empty() ? first : first + previous_polygon[1] - previous_polygon[0];
}

}  // namespace fb::archive
