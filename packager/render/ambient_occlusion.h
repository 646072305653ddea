#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "base/vector3.h"

namespace fb::tool {

// Ambient light that reaches each vertex past the mesh itself: 1 in the open, near 0 deep in a mouth. Cosine-weighted,
// as for a Lambertian surface. triangles: three vertex indices each; points: 3 x vertices; normals: one a vertex.
std::vector<float> vertex_ambient_occlusion(std::span<const std::uint32_t> triangles, std::span<const float> points,
                                            std::span<const Vector3> normals, const Parallel& parallel);

}  // namespace fb::tool
