#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "base/vector3.h"

namespace fb {

// How much of the sky over each vertex is not hidden by the mesh itself: 1 in the open, near 0 deep in a mouth.
// Weighted by the cosine to the normal, as matt surfaces gather light. triangles: three vertex indices each; points: 3
// x vertices.
std::vector<float> vertex_exposure(std::span<const std::uint32_t> triangles, std::span<const float> points,
                                   std::span<const Vector3> normals, const Parallel& parallel);

}  // namespace fb
