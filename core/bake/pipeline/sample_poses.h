#pragma once

#include <memory>

#include "bake/recipe/bake_options.h"
#include "bake/rig/rig_evaluator.h"
#include "bake/sampling/sampling.h"
#include "base/progress.h"

namespace fb::bake {

enum class SampledSplits {
  training,
  training_and_test,  // the rig's test clips too, or held-out random poses and synthetic shots where it has none
};

struct WantedPoses {
  std::uint64_t count = 0;
  bool linear = false;  // fewer than usual, as the rig was found to be
};

// How many poses to sample: BakeOptions::poses, or where that is 0, 2,000 of a rig that is_linear finds linear, with a
// note, if the recipe analyses rigs itself, nothing says which poses matter, and a budget, if there is one, has 10,000
// or more, for of such a rig more change nothing; otherwise all of the rig budget, or 20,000.
WantedPoses wanted_poses(RigEvaluator& rig, const BakeOptions& options, bool recipe_evaluates, Progress& progress);

// How sample_poses samples a rig.
SamplingOptions sampling_options(const RigEvaluator& rig, const BakeOptions& options, SampledSplits splits,
                                 bool recipes_evaluate);

// Samples a live rig into a dataset in the work folder, or finds it there, and opens it. `recipes_evaluate`: recipes
// evaluate the rig themselves. A third of a rig budget is then kept for them (nothing, if analysis with a third is not
// worthwhile, see pays_to_analyse), and half of the poses are chosen by active sampling.
OpenedSource sample_poses(RigEvaluator& rig, const BakeOptions& options, SampledSplits splits, bool recipes_evaluate,
                          Progress& progress);

// The options of one of `recipes` bakes that share equally what the rig has left of its budget, at least 1 pose.
BakeOptions with_budget_left(BakeOptions options, const RigEvaluator& rig, std::size_t recipes);

}  // namespace fb::bake
