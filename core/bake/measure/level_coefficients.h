#pragma once

#include "bake/measure/errors.h"
#include "bake/rig/pose_set.h"
#include "base/parallel.h"
#include "model/packed_model.h"

namespace fb::bake {

// Chooses which coefficients the levels of a model use: at level k those are left out that in up to 500 of the poses
// move its vertices least, as long as together (their squares) they move them by at most 2^k - 1 times the root mean
// square error of the whole, and none moves a vertex by more than k / 2 times its largest error. Those that channels
// use stay. `whole`: errors at level 0. What a level uses, those before it use.
void choose_level_coefficients(PackedModel& model, const PoseSet& poses, const Errors& whole, const Parallel& parallel);

}  // namespace fb::bake
