// Reads archives of format version 0.2, for `facebaker pack` to convert. Versions before 1.0 were never stable.
#pragma once

#include <cstddef>
#include <span>

#include "archive/reader.h"

namespace fb::archive {

bool is_version_0_2(std::span<const std::byte> bytes);

// As read_archive, without the proof, which had another meaning. Sorts the features of gates by control, as version 1.0
// requires.
Archive read_version_0_2(std::span<const std::byte> bytes, const ReadLimits& limits = {});

}  // namespace fb::archive
