#pragma once

#include "bake/recipe/bake_options.h"
#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"

namespace fb::bake {

// Has a rig, for a recipe that evaluates it, say what its driven joints do as single controls act on them, see
// compose_joints(), unless there are none or the budget of the options is too small to analyse the rig.
void compose_rig(RigEvaluator& rig, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
