#pragma once

#include <vector>

#include "bake/analysis/activation_curve.h"
#include "bake/analysis/rig_analysis.h"
#include "bake/rig/rig_evaluator.h"

namespace fb::bake {

// Limits of the curves of a rig with this diagonal.
CurveLimits curve_limits(const AnalysisOptions& options, double diagonal);

// Fits an activation curve to every control of a live rig. `motion` becomes the largest distance each control alone
// moves every vertex (controls x vertices, over D). Samples eighths of both sides of rest first, then refines where
// curves bend, a few controls at a time. Where the budget does not suffice, controls get fewer samples, at the least
// the ends of their range, in order.
std::vector<ControlCurve> fit_excitations(RigEvaluator& rig, const AnalysisOptions& options, std::vector<float>& motion,
                                          Progress& progress);

// Positions of a control at which correctives are sampled, four at most, eight if its curve jumps: the ends of its
// range, the knots of its curve, then fixed fractions.
std::vector<double> knot_positions(const Control& control, const ControlCurve& curve);

// Rig minus curve at the knot positions of a control, rig units. It is subtracted before correctives are fitted, so
// that they do not take up the errors of curves.
struct CurveErrors {
  std::vector<double> positions;  // as knot_positions orders them
  std::vector<SparseShape> errors;
};

// One for each control.
std::vector<CurveErrors> measure_curves(RigEvaluator& rig, const std::vector<ControlCurve>& curves, Progress& progress);

// Largest distance of each control's curve from the rig, over D, at three positions of each side drawn from the seed;
// at one, if there is a budget.
std::vector<double> validate_curves(RigEvaluator& rig, const std::vector<ControlCurve>& curves, std::uint64_t seed,
                                    Progress& progress);

}  // namespace fb::bake
