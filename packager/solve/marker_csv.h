#pragma once

#include <filesystem>

#include "solve/marker_take.h"

namespace fb::tool {

// Reads a table of markers: a line of names, then a line a frame. The column "time" has seconds, from which the rate
// follows; a column "frame" is not used. All others come in threes, NAME.x, NAME.y and NAME.z, in any order, also with
// "_", ":" or a blank before the axis, and without regard to its case. Separators, quotes and decimal commas are as in
// csv_file.h. The unit is not in the file. Fails as read_marker_file does, and with bad_data, naming the line, where
// steps of time are not equal within half a step.
MarkerTake read_marker_csv(const std::filesystem::path& path);

}  // namespace fb::tool
