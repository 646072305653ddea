// What shading and measuring need to know of a posed mesh at its vertices.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/vector3.h"

namespace fb {

// Unit normals, averaged over the polygons around a vertex weighted by their area; null where there is no polygon.
// triangles: three vertex indices each; points: 3 x vertices.
std::vector<Vector3> vertex_normals(std::span<const std::uint32_t> triangles, std::span<const float> points);

}  // namespace fb
