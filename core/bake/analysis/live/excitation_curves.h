#pragma once

#include <vector>

#include "bake/analysis/activation_curve.h"
#include "bake/analysis/rig_analysis.h"
#include "bake/rig/rig_evaluator.h"

namespace fb::bake {

// Curves of all controls, and how far each moves every vertex alone (controls x vertices, over D). Samples eighths of
// every side of rest first, then where curves bend, in waves over some controls at a time. Controls for which the
// budget does not suffice get the chord to as many ends as it allows.
std::vector<ControlCurve> fit_excitations(RigEvaluator& rig, const AnalysisOptions& options, std::vector<float>& motion,
                                          Progress& progress);

// Places of a control at which correctives are looked for: an end of its range first, the most telling next.
std::vector<double> telling_places(const Control& control, const ControlCurve& curve);

// What a curve leaves over at its telling places, rig units: what is subtracted before correctives are fitted, so that
// they do not take up the errors of curves.
struct CurveErrors {
  std::vector<double> places;       // of one control, as telling_places orders them
  std::vector<SparseShape> errors;  // of each place
};

// One a control.
std::vector<CurveErrors> measure_curves(RigEvaluator& rig, const std::vector<ControlCurve>& curves, Progress& progress);

// Largest distance of curves from the rig, over D, at a place of each side drawn from the seed.
double test_curves(RigEvaluator& rig, const std::vector<ControlCurve>& curves, std::uint64_t seed, Progress& progress);

}  // namespace fb::bake
