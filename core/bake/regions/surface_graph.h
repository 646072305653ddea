#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "model/mesh.h"

namespace fb::bake {

// The vertices of a mesh and the edges of its polygons, as adjacency lists.
class SurfaceGraph {
 public:
  struct Edge {
    std::uint32_t vertex = 0;  // at the other end
    float length = 0;          // in the rest pose
  };

  // `welded`: further pairs of vertices that count as connected.
  SurfaceGraph(const Mesh& rest, std::span<const std::pair<std::uint32_t, std::uint32_t>> welded);

  std::size_t size() const { return first_.size() - 1; }
  // The edges of a vertex, by ascending neighbour, each once.
  std::span<const Edge> edges(std::uint32_t vertex) const {
    return std::span(edges_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

  // Geodesic distance along edges: lowers `distance` (one a vertex, infinite where unknown) to the shortest path from
  // any vertex whose distance is finite, up to `max_distance`. Vertices with `passable` 0 are never entered. Edges
  // longer than `max_edge` count as that long.
  void geodesic_distances(std::span<double> distance, std::span<const char> passable, double max_edge,
                          double max_distance) const;

  // The connected components of equal label, each in ascending order, sorted by their first vertices.
  std::vector<std::vector<std::uint32_t>> components(std::span<const std::uint32_t> labels) const;

 private:
  std::vector<std::size_t> first_;  // of each vertex's edges; size() + 1 entries
  std::vector<Edge> edges_;
};

}  // namespace fb::bake
