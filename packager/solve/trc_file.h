#pragma once

#include <filesystem>

#include "solve/marker_take.h"

namespace fb::tool {

// Reads a track row column file, which Motion Analysis brought in and OpenSim, Motive, Cortex, Mokka and others write.
// Five lines, separated by tabs, come before the frames: "PathFileType", names of fields, their values, names of
// markers, labels of axes. Of the fields, DataRate, NumMarkers and Units are needed, in any order. A row of a frame has
// its number, its time, which is not used, and three cells a marker; cells at its end may be left out. Fails as
// read_marker_file does.
MarkerTake read_trc_file(const std::filesystem::path& path);

}  // namespace fb::tool
