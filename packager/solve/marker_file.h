// Files of captured markers; docs/solve-targets.md describes them.
#pragma once

#include <filesystem>

#include "solve/marker_take.h"

namespace fb::tool {

// Reads a take by the extension of its name: .trc or .csv. A marker is missing in a frame where its three cells are
// empty or "NaN", or all zero. Fails with bad_data, naming file, line, marker and frame, on anything else that is no
// position: text, an infinite number, one or two coordinates of three, what is more than a kilometre away; and on names
// that occur twice. Fails with limit beyond 1 GiB, 4,096 markers or 32 million positions, with invalid_argument for
// another extension, and as read_file does.
MarkerTake read_marker_file(const std::filesystem::path& path);

}  // namespace fb::tool
