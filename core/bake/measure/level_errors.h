#pragma once

#include <vector>

#include "bake/measure/errors.h"
#include "bake/rig/pose_set.h"
#include "base/parallel.h"
#include "model/packed_model.h"

namespace fb::bake {

// A level of detail against its rig.
struct LevelErrors {
  std::size_t vertices = 0, polygons = 0;
  std::size_t coefficients = 0;  // that move its vertices
  Errors own;                    // of the level's own vertices
  Errors surface;                // of all vertices of the whole, as they lie on the level's surface
};

// Errors of all levels but 0, in up to 500 of the poses.
std::vector<LevelErrors> measure_levels(const PackedModel& model, const PoseSet& poses, const Parallel& parallel);

}  // namespace fb::bake
