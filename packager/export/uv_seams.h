#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/mesh.h"

namespace fb {

// A mesh for files that know one pair of texture coordinates a vertex: where a vertex lies on a seam, copies of it,
// after all others, have its other pairs.
struct SplitMesh {
  std::vector<std::uint32_t> copied;  // the vertex each copy is of
  std::vector<float> uvs;             // one pair a vertex and copy, (0, 0) for a vertex without a polygon; may be empty
  std::vector<std::uint32_t> triangles;  // of vertices and copies

  // 3 x vertices numbers, with those of the copies.
  std::vector<float> with_copies(std::span<const float> vectors) const;
};

SplitMesh split_at_seams(const Mesh& mesh);

}  // namespace fb
