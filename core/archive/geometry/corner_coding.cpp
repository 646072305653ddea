#include "archive/geometry/corner_coding.h"

#include <algorithm>

#include "archive/container/container_layout.h"

namespace fb::archive {

std::vector<std::uint32_t> corner_deltas(const std::vector<std::uint32_t>& sizes,
                                         const std::vector<std::uint32_t>& corners) {
  std::vector<std::uint32_t> deltas;
  std::size_t at = 0;
  std::uint32_t previous_size = 0;
  for (const std::uint32_t size : sizes) {
    for (std::uint32_t k = 0; k < size; ++k, ++at)
      deltas.push_back(to_zigzag(corners[at] - predicted_corner(corners, at, k, previous_size)));
    previous_size = size;
  }
  return deltas;
}

void restore_corners(std::span<const std::uint32_t> sizes, std::span<std::uint32_t> deltas) {
  std::size_t at = 0;
  std::uint32_t previous_size = 0;
  for (const std::uint32_t size : sizes) {
    for (std::uint32_t k = 0; k < size; ++k, ++at)
      deltas[at] = predicted_corner(deltas, at, k, previous_size) + from_zigzag(deltas[at]);
    previous_size = size;
  }
}

TriangleEdges::TriangleEdges(const std::vector<std::uint32_t>& triangles, std::uint32_t vertices,
                             std::pmr::memory_resource& memory)
    : first_(std::size_t(vertices) + 1, &memory), edges_(triangles.size(), &memory) {
  for (const std::uint32_t corner : triangles) ++first_[corner];
  std::uint32_t sum = 0;
  for (std::uint32_t& first : first_) first = sum += first;
  for (std::size_t t = 0; t + 3 <= triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k)
      edges_[--first_[triangles[t + k]]] = {triangles[t + (k + 1) % 3], triangles[t + (k + 2) % 3]};
}

std::span<const TriangleEdges::Edge> sorted_edges(const TriangleEdges& edges, std::uint32_t vertex,
                                                  std::uint32_t prediction, SortedEdges& room) {
  const auto from = edges.from(vertex);
  if (from.size() > max_edges) return {};
  const auto sorted = std::span(room).first(from.size());
  std::copy(from.begin(), from.end(), sorted.begin());
  std::sort(sorted.begin(), sorted.end(),
            [&](const auto& a, const auto& b) { return to_zigzag(a.to - prediction) < to_zigzag(b.to - prediction); });
  const auto same = [](const auto& a, const auto& b) { return a.to == b.to; };
  if (std::adjacent_find(sorted.begin(), sorted.end(), same) != sorted.end()) return {};
  return sorted;
}

}  // namespace fb::archive
