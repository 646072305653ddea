#pragma once

#include <cstddef>
#include <vector>

#include "bake/check/dataset_files.h"
#include "bake/check/findings.h"
#include "base/progress.h"

namespace fb::bake {

// What points show, beside findings.
struct PointsSeen {
  std::size_t frames = 0;            // read
  std::vector<float> vertex_motion;  // of each vertex, the largest distance from rest in any frame, over the diagonal
  std::vector<float> frame_motion;   // of each frame of clips with points, its worst vertex; clip by clip
};

// Reads all points and finds what is wrong with them: not finite or too far away; frames with the points of another
// pose; poses that are not the same each time; a rest pose that is not the rest mesh; controls that move nothing.
PointsSeen check_points(const DatasetFiles& files, Findings& findings, Progress& progress);

}  // namespace fb::bake
