// The memory that a face's scratches take.
#pragma once

#include <cstddef>
#include <facebaker/facebaker_bake.hpp>

namespace fb::tool {

// Bytes of one worker's scratch, of fb_scratch_create and of fb_scratch_create_single.
struct ScratchBytes {
  std::size_t batches = 0, single = 0;
};
ScratchBytes scratch_bytes(const fb_archive_info& archive);

}  // namespace fb::tool
