#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/mesh_view.h"

namespace fb::tool {

// A mesh for formats with one texture coordinate a vertex: vertices on UV seams are duplicated, after all others.
struct SplitMesh {
  std::vector<std::uint32_t> copied;     // the original vertex of each copy
  std::vector<float> uvs;                // u and v of each vertex and copy; (0, 0) without a polygon; empty: none
  std::vector<std::uint32_t> triangles;  // of vertices and copies

  // 3 x vertices numbers, followed by those of the copies.
  std::vector<float> with_copies(std::span<const float> vectors) const;
};

SplitMesh split_at_seams(const MeshView& mesh);

}  // namespace fb::tool
