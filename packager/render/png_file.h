#pragma once

#include <filesystem>

#include "render/image.h"

namespace fb {

// Writes a PNG, whole or not at all; fails with io and the path.
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace fb
