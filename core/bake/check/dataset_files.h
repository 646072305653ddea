// Opens all that a dataset folder names, and goes on where something is wrong.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "bake/check/findings.h"
#include "bake/dataset/dataset_index.h"
#include "bake/dataset/dataset_source.h"
#include "bake/rig/source.h"

namespace fb::bake {

// A clip as far as it could be read.
struct ClipFiles {
  Clip clip;                      // controls: empty where they could not be read; values that are not finite stay
  std::size_t evaluated = 0;      // frames that there are points of, at most clip.frames
  ShardedArray points, channels;  // without rows where there is anything wrong with them, or a plan waits for frames
};

struct DatasetFiles {
  DatasetIndex index;
  bool schema_checked = false;  // whether the controls make sense
  std::optional<Mesh> rest;     // checked
  std::vector<ClipFiles> clips;
};

// Reads dataset.json, the rest mesh, what belongs to the character, all controls, and the headers of all points.
DatasetFiles open_files(const std::filesystem::path& folder, Findings& findings);

}  // namespace fb::bake
