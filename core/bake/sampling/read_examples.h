// Control curves from outside, near which a live rig is sampled.
#pragma once

#include <string>
#include <vector>

#include "bake/rig/source.h"
#include "base/progress.h"

namespace fb::bake {

// The frames of files as poses of a rig, frames x controls, clamped into their ranges. A file is
//   a .npy of frames x controls in the rig's order;
//   a .csv whose first line names its columns, such as a take of Live Link Face;
//   a dataset folder, of which the clips that are not marked test are read.
// Columns of the latter two are matched to controls by their own, ARKit and FACS names (match_names); others are noted,
// and controls without a column stay at rest. Frames that the rig's own test clips have are left out, with a note.
// Fails naming file, line and column; and with invalid_argument if no frame is left.
std::vector<float> read_examples(const std::vector<std::string>& files, const Source& rig, Progress& progress);

// The frames of one such file, all of them.
std::vector<float> read_pose_file(const std::string& file, const RigSchema& schema, Progress& progress);

}  // namespace fb::bake
