#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "bake/analysis/recorded/regression.h"

namespace fb::bake {

using ControlPair = std::pair<std::uint32_t, std::uint32_t>;

// Pairs of controls, `most` at most, whose product what is left of the poses goes along with more than by chance;
// features[c] is what control c enters products as. Those that explain most come first, a few at a time, each time
// judged by what those before leave. Compares a random projection of the poses (Johnson, Lindenstrauss, Contemp. Math.
// 26, 1984), drawn from the seed, instead of every vertex.
std::vector<ControlPair> telling_pairs(const RecordedPoses& recorded, std::span<const Feature> features,
                                       std::size_t most, std::uint64_t seed, const Parallel& parallel,
                                       Progress& progress);

}  // namespace fb::bake
