#pragma once

#include <vector>

#include "bake/analysis/curve_jumps.h"
#include "bake/analysis/live/corrective_search.h"
#include "bake/analysis/rig_analysis.h"
#include "bake/rig/rig_evaluator.h"

namespace fb::bake {

// Samples a hundred positions a side and more of curves that are steep in one place or have errors (in validation, over
// three times the tolerance), and fits those again that jump or are off by ten times the tolerance. Jumps are bisected
// to neighbouring values of the control and become steps; what is left is a curve of up to 256 knots. `errors`: of
// validate_curves; those of curves that change are replaced by the largest error at the samples. Curves that stay as
// wrong as they were are left alone. Uses at most half of the rig calls that the budget leaves.
void refit_difficult_curves(RigEvaluator& rig, const AnalysisOptions& options, std::vector<ControlCurve>& curves,
                            std::vector<double>& errors, Progress& progress);

// The jumps of a control alone that sixteen samples of each side show, by more than least_jump times the tolerance
// (over D); none if the budget does not suffice.
std::vector<Jump> find_jumps_alone(RigEvaluator& rig, std::uint32_t control, double tolerance, EvaluationStage& stage);

// Looks for jumps that controls make only together with others: samples every control of a misfit (see
// CorrectiveSearch) in its pose, and adds the steps it finds to the control's curve, for correctives to be made of.
// Returns whether there are any.
bool add_joint_steps(RigEvaluator& rig, const AnalysisOptions& options, const CorrectiveSearch& correctives,
                     std::vector<ControlCurve>& curves, Progress& progress);

}  // namespace fb::bake
