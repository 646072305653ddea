#pragma once

#include <filesystem>

#include "render/image.h"

namespace fb::tool {

// Writes a PNG, complete or not at all. Fails with io, naming the path.
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace fb::tool
