// How densely vertices lie.
#pragma once

#include <vector>

#include "model/mesh.h"

namespace fb::bake {

// By vertex: the root of its share of the area of its triangles, over the median of all vertices; 1 for a vertex
// without one. Where it is small, vertices lie densely, and the same displacement turns normals more, in proportion.
std::vector<float> vertex_spacing(const Mesh& rest);

}  // namespace fb::bake
