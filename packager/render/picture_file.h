#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "render/texture.h"

namespace fb::tool {

// Decodes a PNG (libpng), a JPEG (libjpeg-turbo) or a WebP (libwebp), by what it begins with. Nothing if it is of
// another kind, broken, or has more than 8192 pixels along an edge. Files come from anywhere.
std::optional<Texture> read_picture_file(std::span<const std::byte> file);

}  // namespace fb::tool
