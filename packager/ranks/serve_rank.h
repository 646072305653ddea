#pragma once

#include <cstdint>

#include "ranks/rank_link.h"

namespace fb::tool {

// What every rank but the first does: opens the sources that rank 0 names, and evaluates their poses on so many
// threads, until rank 0 says that there is no more to do.
void serve_rank(RankLink& link, std::uint32_t threads);

// Poses that keep all at work that evaluates an opened source in this process.
std::uint32_t poses_at_once(const fb_source_info& info, std::uint32_t threads);

}  // namespace fb::tool
