#pragma once

#include <cstddef>
#include <vector>

#include "render/image.h"

namespace fb::tool {

// An image as a small PNG of at most 256 colours: as many bits of each channel are kept as that allows, and pixels that
// agree in them have their mean colour.
std::vector<std::byte> palette_png(const Image& image);

}  // namespace fb::tool
