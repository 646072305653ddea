#pragma once

#include <facebaker/facebaker.h>

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <vector>

#include "base/memory_budget.h"

namespace fb::capi {

// The bytes of the archive that begins a host's stream, and none behind it; fewer if the stream ends early. Fails with
// limit if the archive has more than `limit` bytes, with io if `read` fails, and as archive_size() does.
std::pmr::vector<std::byte> read_stream(fb_read read, void* user, std::uint64_t limit, MemoryBudget& budget);

}  // namespace fb::capi
