#pragma once

#include <cstdint>
#include <span>

#include "bake/analysis/live/corrective_search.h"
#include "bake/analysis/rig_analysis.h"
#include "bake/rig/rig_evaluator.h"

namespace fb::bake {

// Looks for correctives that the search has missed. Evaluates fresh random poses, dense and sparse ones, and reduces
// the worst to the fewest controls that keep half of the residual (see PoseReduction). Two to four controls that have
// no corrective are added to `correctives`, and fresh poses are drawn, until none is off by more than twice the
// tolerance, nothing is missed any more, or `most_calls` rig calls, or a quarter of what the budget leaves, are spent.
// A note says what is left.
// `motion`: of RigAnalysis. `base`: the one that `correctives` adds to.
void add_missed_correctives(RigEvaluator& rig, const AnalysisOptions& options, std::span<const float> motion,
                            const SparseBlendshapes& base, std::uint64_t most_calls, CorrectiveSearch& correctives,
                            Progress& progress);

}  // namespace fb::bake
