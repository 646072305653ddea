#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/mesh.h"

namespace fb::bake {

// Cuts the vertices of each label, in each part of the mesh, into blocks of at most `largest` neighbours, by recursive
// bisection along the longest axis of their positions: as few blocks as possible, of nearly equal size. `labels`: by
// vertex, any numbers. Blocks of one part and label follow each other, ascending by part, then by label; vertices of a
// block ascend; every vertex is in one block. coarsest_levels: by vertex, of which a block has but one, the highest
// first, before parts and labels; empty: all the same. Vertices that carry numbers keep their order, whatever their
// labels.
std::vector<std::vector<std::uint32_t>> vertex_blocks(const Mesh& rest, std::span<const std::uint32_t> labels,
                                                      std::uint32_t largest,
                                                      std::span<const std::uint8_t> coarsest_levels = {});

}  // namespace fb::bake
