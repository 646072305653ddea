// How far vertices of two poses lie apart. Poses: 3 floats a vertex.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "base/vector3.h"

namespace fb::bake {

inline float vertex_distance(std::span<const float> a, std::span<const float> b, std::size_t vertex) {
  return length(vector_at(a.data(), vertex) - vector_at(b.data(), vertex));
}

// The vertex that lies furthest apart in two poses of as many vertices, and its distance.
struct FurthestVertex {
  float distance = 0;
  std::uint32_t vertex = 0;
};
inline FurthestVertex furthest_vertex(std::span<const float> a, std::span<const float> b) {
  FurthestVertex furthest;
  for (std::uint32_t v = 0; v < a.size() / 3; ++v)
    if (const float distance = vertex_distance(a, b, v); distance > furthest.distance) furthest = {distance, v};
  return furthest;
}

// most[v] = max(most[v], distance of vertex v / diagonal), for as many vertices as `most` has.
template <class Number>
void raise_to_distances(std::span<Number> most, std::span<const float> a, std::span<const float> b, double diagonal) {
  for (std::size_t v = 0; v < most.size(); ++v)
    most[v] = std::max(most[v], static_cast<Number>(vertex_distance(a, b, v) / diagonal));
}

}  // namespace fb::bake
