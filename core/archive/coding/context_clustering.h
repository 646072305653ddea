// Which contexts of coded symbols share a table of frequencies.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace fb::archive {

using SymbolCounts = std::array<std::uint32_t, 256>;  // how often each symbol occurs

// The table of each context, so that tables and what is coded by them take few bytes: the contexts whose sharing saves
// most share first. Tables are numbered in the order of their first contexts, from 0; there are most_tables at most.
// Contexts in which nothing occurs have table 0.
std::vector<std::uint8_t> cluster_contexts(std::span<const SymbolCounts> contexts);

}  // namespace fb::archive
