#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/mesh.h"

namespace fb::bake {

// Vertices of equal label cut into chunks of neighbours of at most `largest`: halved across the longest axis of their
// positions until they fit, in as few chunks as possible and nearly equal. `labels`: one a vertex, any numbers. Chunks
// of one label follow each other, ascending by label; vertices of a chunk ascend; every vertex is in one chunk.
std::vector<std::vector<std::uint32_t>> vertex_blocks(const Mesh& rest, std::span<const std::uint32_t> labels,
                                                      std::uint32_t largest);

}  // namespace fb::bake
