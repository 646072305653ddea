// Normals of a posed mesh, for shading, export and measuring.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/vector3.h"

namespace fb {

// Unit vertex normals, averaged over the adjacent triangles weighted by their area; null for a vertex without one.
// triangles: three vertex indices each; points: 3 x vertices.
std::vector<Vector3> vertex_normals(std::span<const std::uint32_t> triangles, std::span<const float> points);

}  // namespace fb
