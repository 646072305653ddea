// The picture of a face in its archive, which file managers show.
#pragma once

#include <cstddef>
#include <facebaker/facebaker.hpp>
#include <vector>

#include "base/parallel.h"

namespace facebaker {
class Source;
}

namespace fb::tool {

// The rest pose as a PNG for an archive (FB_THUMBNAIL_BYTES); the same bytes whatever the number of threads.
std::vector<std::byte> draw_thumbnail(const facebaker::Source& source, const Parallel& parallel);
std::vector<std::byte> draw_thumbnail(const facebaker::Model& model, const Parallel& parallel);

}  // namespace fb::tool
