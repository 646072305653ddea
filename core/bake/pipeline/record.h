#pragma once

#include <memory>

#include "bake/pipeline/bake.h"
#include "bake/rig/rig_evaluator.h"

namespace fb::bake {

// File in the work folder for evaluations of a slow rig, shared by all stages of a bake or comparison.
inline constexpr const char* evaluations_name = "rig.evaluations";

enum class Recording {
  training_only,
  with_test,  // the rig's test clips too, or held-out random poses and synthetic shots where it has none
};

// Samples a live rig into a dataset in the work folder, or finds it there, and opens it. `recipes_ask`: a third of the
// rig budget, if there is one, is kept for recipes that ask the rig themselves (none if that is too little, see
// pays_to_analyse), and half of the poses are chosen by variance: where poses are dear, those that teach most are
// asked for.
std::unique_ptr<Source> record(RigEvaluator& rig, const BakeOptions& options, Recording what, bool recipes_ask,
                               Progress& progress);

// The options of one of `recipes` that share equally what a rig budget still holds.
BakeOptions with_budget_left(BakeOptions options, const RigEvaluator& rig, std::size_t recipes);

}  // namespace fb::bake
