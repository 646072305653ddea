#pragma once

#include <span>
#include <vector>

#include "bake/analysis/recorded/regression.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Controls x vertices, over D: the largest distance that parts of a base move each vertex with each control of theirs,
// the others of the part at the ends of their ranges.
std::vector<float> motion_of(const RigSchema& schema, std::span<const SparseBlendshapes* const> parts,
                             std::size_t vertices, double diagonal, const Parallel& parallel);

// Controls x vertices, over D: by how much more (root mean square) poses are missed at a vertex while a control that
// moves it is on than while it is off; 0 where chance may account for that.
std::vector<float> missed_with(const RecordedPoses& recorded, std::span<const float> motion, double diagonal,
                               const Parallel& parallel, Progress& progress);

}  // namespace fb::bake
