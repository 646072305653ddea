#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "model/mesh.h"

namespace fb::bake {

// Vertices of a mesh and the edges of its polygons between them.
class SurfaceGraph {
 public:
  struct Edge {
    std::uint32_t vertex = 0;  // at the other end
    float length = 0;          // in the rest pose
  };

  // `joined`: more pairs of vertices that count as connected.
  SurfaceGraph(const Mesh& rest, std::span<const std::pair<std::uint32_t, std::uint32_t>> joined);

  std::size_t size() const { return first_.size() - 1; }
  // Of one vertex, by the vertex at the other end, each once.
  std::span<const Edge> edges(std::uint32_t vertex) const {
    return std::span(edges_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

  // Lowers `distance` (one a vertex, infinite where nothing is known) to the shortest path along edges from any vertex
  // that has one, up to `reach`. Vertices with `open` 0 are never entered. An edge longer than `longest` counts as
  // that long.
  void spread(std::span<double> distance, std::span<const char> open, double longest, double reach) const;

  // The connected pieces of equal label, each in ascending order, by their first vertex.
  std::vector<std::vector<std::uint32_t>> pieces(std::span<const std::uint32_t> labels) const;

 private:
  std::vector<std::size_t> first_;
  std::vector<Edge> edges_;
};

}  // namespace fb::bake
