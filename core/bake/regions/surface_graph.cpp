#include "bake/regions/surface_graph.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>

namespace fb::bake {

SurfaceGraph::SurfaceGraph(const Mesh& rest, std::span<const std::pair<std::uint32_t, std::uint32_t>> welded) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    if (a == b) return;
    pairs.emplace_back(a, b);
    pairs.emplace_back(b, a);
  };
  std::size_t first = 0;
  for (const std::uint32_t corners : rest.polygon_sizes) {
    for (std::uint32_t k = 0; k < corners; ++k)
      join(rest.polygon_corners[first + k], rest.polygon_corners[first + (k + 1) % corners]);
    first += corners;
  }
  for (const auto& [a, b] : welded) join(a, b);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());

  first_.assign(rest.vertex_count() + 1, 0);
  for (const auto& [a, b] : pairs) {
    const float* p = rest.points.data() + 3 * std::size_t(a);
    const float* q = rest.points.data() + 3 * std::size_t(b);
    edges_.push_back({b, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2])});
    ++first_[a + 1];
  }
  for (std::size_t v = 0; v < rest.vertex_count(); ++v) first_[v + 1] += first_[v];
}

// Dijkstra's algorithm with many sources.
void SurfaceGraph::geodesic_distances(std::span<double> distance, std::span<const char> passable, double max_edge,
                                      double max_distance) const {
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (std::uint32_t v = 0; v < size(); ++v)
    if (distance[v] < INFINITY) queue.emplace(distance[v], v);
  while (!queue.empty()) {
    const auto [here, v] = queue.top();
    queue.pop();
    if (here > distance[v]) continue;  // outdated entry
    for (const Edge& edge : edges(v)) {
      const double there = here + std::min<double>(edge.length, max_edge);
      if (!passable[edge.vertex] || there > max_distance || there >= distance[edge.vertex]) continue;
      distance[edge.vertex] = there;
      queue.emplace(there, edge.vertex);
    }
  }
}

std::vector<std::vector<std::uint32_t>> SurfaceGraph::components(std::span<const std::uint32_t> labels) const {
  std::vector<std::vector<std::uint32_t>> components;
  std::vector<char> visited(size(), 0);
  for (std::uint32_t start = 0; start < size(); ++start) {
    if (visited[start]) continue;
    std::vector<std::uint32_t> component = {start};
    visited[start] = 1;
    for (std::size_t next = 0; next < component.size(); ++next)
      for (const Edge& edge : edges(component[next]))
        if (!visited[edge.vertex] && labels[edge.vertex] == labels[start]) {
          visited[edge.vertex] = 1;
          component.push_back(edge.vertex);
        }
    std::sort(component.begin(), component.end());
    components.push_back(std::move(component));
  }
  return components;
}

}  // namespace fb::bake
