// Archives of format version 0.2, which was never stable: what `facebaker pack` turns into archives of this version.
#pragma once

#include <cstddef>
#include <span>

#include "archive/reader.h"

namespace fb::archive {

bool is_version_0_2(std::span<const std::byte> bytes);

// As read_archive; the proof, which was another then, is left out. What a gate looks at is put in the order that
// version 1.0 asks for.
Archive read_version_0_2(std::span<const std::byte> bytes, const ReadLimits& limits = {});

}  // namespace fb::archive
