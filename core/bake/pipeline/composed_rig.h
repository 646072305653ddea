#pragma once

#include <memory>

#include "bake/recipe/bake_options.h"
#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"

namespace fb::bake {

// A live rig whose driven joints are said as single controls act on them, and what it took to find that out.
struct ComposedRig {
  std::unique_ptr<Source> source;  // null: as the rig gives them
  EvaluationCounts counts = {};
  std::uint64_t asked = 0, evaluated = 0;
};

// Finds it by compose_joints(), for a recipe that evaluates the rig, unless there are no driven joints, or the budget
// of the options is too small to analyse the rig. Evaluations are kept in the work folder as those of the bake are.
// `rig` must outlive the source.
ComposedRig compose_rig(Source& rig, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
