// Context clustering: which contexts share a frequency table.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "archive/coding/writer/rans_writer.h"

namespace fb::archive {

// The table of each context, such that tables and coded symbols together take few bytes. Greedy: the pair of tables
// whose merging saves most is merged first. Tables are numbered from 0 in the order of their first contexts, at most
// max_tables. Contexts without symbols get table 0.
std::vector<std::uint8_t> cluster_contexts(std::span<const SymbolCounts> contexts);

}  // namespace fb::archive
