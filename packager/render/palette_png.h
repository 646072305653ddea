#pragma once

#include <cstddef>
#include <vector>

#include "render/image.h"

namespace fb::tool {

// An image as a small PNG of at most 256 colours (palette_of), of which pixels take at most a byte and 1 in a thousand.
std::vector<std::byte> palette_png(const Image& image);

}  // namespace fb::tool
