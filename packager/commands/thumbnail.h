// The picture of a face in its archive, which file managers show.
#pragma once

#include <facebaker/facebaker_bake.h>

#include <cstddef>
#include <facebaker/facebaker.hpp>
#include <vector>

#include "base/parallel.h"

namespace fb::tool {

// The rest pose in the colours of its materials, of a body the part that moves, as a PNG for an archive
// (FB_THUMBNAIL_BYTES); the same bytes whatever the number of threads.
std::vector<std::byte> draw_thumbnail(const facebaker::Model& model, const Parallel& parallel);

// Has a bake draw it. `parallel` must outlive the bake, and has no progress.
void draw_thumbnail_of(fb_bake_desc& bake, Parallel& parallel);

}  // namespace fb::tool
