#pragma once

#include <cstdint>
#include <vector>

#include "render/image.h"

namespace fb::tool {

struct Palette {
  std::vector<Rgb> colours;           // at most 256, by green, red and blue, so that neighbours are alike
  std::vector<std::uint8_t> indices;  // of each pixel
};

// Few colours for an image, which are means: of pixels that agree in the upper six or five bits of each channel where
// that gives at most 256, as of a shaded face of clay; of one with textures, colours are split at their mean, those
// that differ most along the channel in which they do, until there are 256 groups.
Palette palette_of(const Image& image);

}  // namespace fb::tool
