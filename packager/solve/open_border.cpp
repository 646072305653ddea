#include "solve/open_border.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>
#include <utility>

namespace fb::tool {
namespace {

// For each vertex the first one at its place.
std::vector<std::uint32_t> welded(std::span<const float> points) {
  const auto place = [&](std::uint32_t v) { return std::tuple(points[3 * v], points[3 * v + 1], points[3 * v + 2]); };
  std::vector<std::uint32_t> order(points.size() / 3), same(order.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order,
                    [&](std::uint32_t a, std::uint32_t b) { return std::pair(place(a), a) < std::pair(place(b), b); });
  for (std::size_t i = 0; i < order.size(); ++i)
    same[order[i]] = i > 0 && place(order[i]) == place(order[i - 1]) ? same[order[i - 1]] : order[i];
  return same;
}

struct Edge {
  std::uint32_t a = 0, b = 0;  // a < b
  std::uint32_t triangle = 0;
  std::uint8_t corner = 0;  // opposite
  auto ends() const { return std::pair(a, b); }
};

}  // namespace

OpenBorder::OpenBorder(std::span<const float> points, std::span<const std::uint32_t> triangles)
    : edges_(triangles.size() / 3), vertices_(points.size() / 3) {
  const std::vector<std::uint32_t> same = welded(points);
  std::vector<Edge> edges;
  for (std::uint32_t t = 0; t < edges_.size(); ++t) {
    const std::array<std::uint32_t, 3> v = {same[triangles[3 * t]], same[triangles[3 * t + 1]],
                                            same[triangles[3 * t + 2]]};
    for (std::uint8_t k = 0; k < 3; ++k) {
      const std::uint32_t a = v[(k + 1) % 3], b = v[(k + 2) % 3];
      if (a != b) edges.push_back({std::min(a, b), std::max(a, b), t, k});
    }
  }
  std::ranges::stable_sort(edges, {}, &Edge::ends);
  std::vector<std::uint8_t> open(vertices_.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool shared = (i > 0 && edges[i - 1].ends() == edges[i].ends()) ||
                        (i + 1 < edges.size() && edges[i + 1].ends() == edges[i].ends());
    if (shared) continue;
    edges_[edges[i].triangle] |= static_cast<std::uint8_t>(1u << edges[i].corner);
    open[edges[i].a] = open[edges[i].b] = 1;
    any_ = true;
  }
  for (std::size_t v = 0; v < vertices_.size(); ++v) vertices_[v] = open[same[v]];
}

bool OpenBorder::has(const ClosestPoint& point) const {
  constexpr float near = 0.01f;
  for (std::size_t k = 0; k < 3; ++k) {
    if ((edges_[point.triangle] >> k & 1) != 0 && point.surface.weights[k] <= near) return true;
    if (point.surface.weights[k] >= 1 - near && vertices_[point.surface.vertices[k]] != 0) return true;
  }
  return false;
}

}  // namespace fb::tool
