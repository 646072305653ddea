#pragma once

#include <cstdint>

#include "ranks/rank_link.h"

namespace fb::tool {

// From now on, commands spread live rigs over the ranks of a job (see set_source_opener). One source at a time is
// spread; another that is open meanwhile is evaluated by rank 0 alone. The link must outlive all sources.
void open_on_ranks(RankLink& link, std::uint32_t threads);

// Tells the other ranks that there is no more to do.
void end_ranks(RankLink& link);

}  // namespace fb::tool
