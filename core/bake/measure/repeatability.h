// Whether a rig gives the same points whenever a pose is evaluated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "bake/rig/pose_set.h"
#include "bake/rig/rig_evaluator.h"
#include "figures/error_figures.h"

namespace fb::bake {

// Poses that are evaluated again, at most.
inline constexpr std::size_t repeated_poses = 16;

// Evaluates at most 16 recorded poses once more, evenly spaced, whatever the cache holds. Counts against no budget.
Repeatability measure_repeatability(const PoseSet& recorded, RigEvaluator& rig, Progress& progress);

// A warning that says which errors the rig's own differences bound; nothing while they are within 1e-5 of the diagonal,
// which is what a rest pose is held to.
std::optional<std::string> repeatability_warning(const Repeatability& repeatability);

}  // namespace fb::bake
