// A point of a mesh's surface, which moves with it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/vector3.h"

namespace fb::tool {

// The weighted sum of three vertices; weights sum to 1.
struct SurfacePoint {
  std::array<std::uint32_t, 3> vertices{};
  std::array<float, 3> weights{};

  // points: 3 x vertices.
  Vector3 at(std::span<const float> points) const {
    Vector3 sum;
    for (std::size_t k = 0; k < 3; ++k) sum = sum + vector_at(points.data(), vertices[k]) * weights[k];
    return sum;
  }
  bool operator==(const SurfacePoint&) const = default;
};

}  // namespace fb::tool
