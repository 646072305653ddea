// What a bake will ask of a live rig, told before it begins.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/recipe/bake_options.h"
#include "bake/recipe/recipe.h"
#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"
#include "figures/face_figures.h"

namespace fb::bake {

// Poses of a stage that are asked for: about so many, and no more than `most`, which is UINT64_MAX where nobody knows.
struct PlannedStage {
  EvaluationPurpose purpose;
  std::uint64_t expected = 0, most = 0;
};

struct EvaluationPlan {
  std::vector<PlannedStage> stages;  // in their order
  double pose_seconds = 0;           // measured; 0: could not be
  // Of the disk, about, for the work folder: sampled poses, and evaluations that are kept (CacheLimit).
  std::uint64_t sampled_bytes = 0, kept_bytes = 0;
  std::uint64_t free_bytes = UINT64_MAX;  // there; UINT64_MAX: not known
};

// The plan of a bake whose recipe uses the rig so, of a rig that is `linear` (see is_linear) or
// not known to be. Evaluates a few single controls, which every plan holds, to see how long a pose takes. Fails as
// sampling does on options that allow for no plan.
EvaluationPlan plan_evaluations(RigEvaluator& rig, const BakeOptions& options, RigUse use, Progress& progress,
                                bool linear = false);

// A table of stages, or a sentence where there is no budget and all takes less than a minute; then what the disk is to
// hold.
std::string text_of(const EvaluationPlan& plan, bool budgeted);

// What was asked, of the stages in which anything was.
std::vector<StageCalls> calls_by_stage(const EvaluationCounts& counts);

}  // namespace fb::bake
