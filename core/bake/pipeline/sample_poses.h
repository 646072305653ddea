#pragma once

#include <memory>

#include "bake/recipe/bake_options.h"
#include "bake/recipe/recipe.h"
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
// or more, for of such a rig more change nothing; otherwise all of the rig budget, or 20,000. A recipe that learns
// nothing has 2,000, of a budget a quarter at most: they measure its face.
WantedPoses wanted_poses(RigEvaluator& rig, const BakeOptions& options, RigUse use, Progress& progress);

// How sample_poses samples a rig.
SamplingOptions sampling_options(const RigEvaluator& rig, const BakeOptions& options, SampledSplits splits, RigUse use);

// Whether a budget is spent by active sampling, which trains networks to choose poses.
inline bool samples_actively(const BakeOptions& options, RigUse use) {
  return options.rig_budget > 0 && use.evaluates && use.learns;
}

// Samples a live rig into a dataset in the work folder, or finds it there, and opens it. For recipes that evaluate the
// rig themselves, a third of a rig budget is kept (nothing, if analysis with a third is not worthwhile, see
// pays_to_analyse), and half of the poses are chosen by active sampling, if they learn.
OpenedSource sample_poses(RigEvaluator& rig, const BakeOptions& options, SampledSplits splits, RigUse use,
                          Progress& progress);

// The options of one of `recipes` bakes that share equally what the rig has left of its budget, at least 1 pose.
BakeOptions with_budget_left(BakeOptions options, const RigEvaluator& rig, std::size_t recipes);

}  // namespace fb::bake
