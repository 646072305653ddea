// What one control moves alone, fitted to samples: as few shapes as a tolerance allows.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "model/rig_schema.h"

namespace fb::bake {

// The rig with one control away from rest. A position is a fraction of the way from rest to an end of the range:
// positive toward the maximum, negative toward the minimum, 1 or -1 at the ends.
struct CurveSamples {
  std::uint32_t control = 0;
  std::vector<double> positions;                  // ascending, none of them 0
  std::vector<std::vector<float>> displacements;  // at each position, 3 x vertices
};

struct CurveLimits {
  double tolerance = 0;  // distance at a vertex, rig units
  double drop = 0;       // shorter offsets are dropped, rig units
  std::uint32_t max_knots = 8;
};

struct ControlCurve {
  SparseBlendshapes part;      // shapes and the features that weigh them; empty if the control moves nothing
  double error = 0;            // largest distance at a sample, rig units
  bool smooth = false;         // one polynomial over the whole range
  std::vector<double> knots;   // positions between rest and the ends where the curve bends, the largest bend first
  bool steep = false;          // between two samples much steeper than beside them: the curve may jump there
  std::vector<Feature> steps;  // of a curve that jumps, see curve_jumps.h; knots are then positions between jumps
};

// The control's value at a position, within its range.
float value_at(const Control& control, double position);
// True if the control can move from rest to that side.
bool has_side(const Control& control, bool up);

// The features a curve may start from: max(u, 0) of a side, u from 0 at rest to 1 at its end; and, across rest,
// u = (value - rest) / reach.
Feature side_ramp(const Control& control, std::uint32_t index, bool up);
Feature across(const Control& control, std::uint32_t index);
// Rises from position `left` to 1 at `knot` and falls to 0 at `right`, all on one side, |left| < |knot| < |right|.
Feature tent(const Control& control, std::uint32_t index, double left, double knot, double right);

// Fits, on each side, a polyline through as few of the samples as the tolerance allows, or a polynomial of fewer
// shapes; one polynomial for both sides if that has fewer still. A polyline is held to a hundredth of the tolerance
// where that takes at most two more knots: the rig's own curve is then a polyline. A polyline is stored as its chord
// and, knot by knot, the difference from the polyline before, so that vertices that move straight are in one shape
// only.
ControlCurve fit_curve(const Control& control, const CurveSamples& samples, const CurveLimits& limits);

// Positions to sample next: in every interval that bends, where the lines through the samples left and right of it
// meet, rounded to a simple fraction nearby; its middle where they do not meet inside.
std::vector<double> positions_to_refine(const CurveSamples& samples, const CurveLimits& limits);

}  // namespace fb::bake
