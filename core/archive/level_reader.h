// Reads the section of levels of detail. Input is untrusted: fails with `corrupt`, `unsupported` or `limit` and names
// section and byte offset.
#pragma once

#include <cstdint>
#include <vector>

#include "archive/container/byte_reader.h"
#include "model/detail_levels.h"

namespace fb::archive {

// How the polygon corners of a level map to texture coordinates.
enum class LevelUvCoding : std::uint32_t { none = 0, deltas = 1, by_vertex = 2 };

// Whether they fit the rest of the archive is checked by check_levels().
std::vector<DetailLevel> read_levels(ByteReader& in);

}  // namespace fb::archive
