// Polygons told along the triangles that Draco keeps of them: a first edge says the rest.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace fb::archive {

// The edges of triangles, each in the direction of its triangle.
class TriangleEdges {
 public:
  struct Edge {
    std::uint32_t to = 0, next = 0;  // the vertex it leads to, and the triangle's third
  };

  // Corners are below `vertices`, three a triangle.
  TriangleEdges(const std::vector<std::uint32_t>& triangles, std::uint32_t vertices);

  std::span<const Edge> from(std::uint32_t vertex) const {
    return {edges_.data() + first_[vertex], edges_.data() + first_[vertex + 1]};
  }

 private:
  std::vector<std::uint32_t> first_;  // of each vertex, and the end
  std::vector<Edge> edges_;
};

// The edges from a vertex, those first that have small steps from `prediction` to where they lead: see to_zigzag. None
// if two lead to one vertex or there are more than most_edges, where triangles do not tell polygons.
inline constexpr std::size_t most_edges = 64;
std::vector<TriangleEdges::Edge> nearest_first(const TriangleEdges& edges, std::uint32_t vertex,
                                               std::uint32_t prediction);

// Where the polygon's second corner is predicted: the first corner goes on from that of the polygon before as this
// does.
inline std::uint32_t predicted_second(std::span<const std::uint32_t> polygon_before, std::uint32_t first) {
  return polygon_before.empty() ? first : first + polygon_before[1] - polygon_before[0];
}

}  // namespace fb::archive
