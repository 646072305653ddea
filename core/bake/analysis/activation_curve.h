// What one control does alone, from samples of it: fewest shapes within a tolerance.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/analysis/sparse_blendshapes.h"
#include "model/rig_schema.h"

namespace fb::bake {

// The rig with one control away from rest. A place is the share of the way from rest to an end of the range: positive
// toward the maximum, negative toward the minimum, 1 or -1 at the ends.
struct CurveSamples {
  std::uint32_t control = 0;
  std::vector<double> places;                     // ascending, none of them 0
  std::vector<std::vector<float>> displacements;  // of each place, 3 x vertices
};

struct CurveLimits {
  double tolerance = 0;  // distance at a vertex, rig units
  double drop = 0;       // offsets not kept, rig units
  std::uint32_t max_knots = 8;
};

struct ControlCurve {
  SparseBlendshapes part;     // its shapes; empty if the control moves nothing
  double error = 0;           // largest distance at a sample, rig units
  bool smooth = false;        // one polynomial through both sides, or the only side, of the range
  std::vector<double> knots;  // places of corners between rest and the ends, those that bend most first
};

// The control's value at a place, within its range.
float value_at(const Control& control, double place);
// True if the control can move from rest to that side.
bool has_side(const Control& control, bool up);

// The features a curve may start from: max(u, 0) of a side, u from 0 to 1 along it; and, across rest, u / reach.
Feature side_ramp(const Control& control, std::uint32_t index, bool up);
Feature across(const Control& control, std::uint32_t index);
// Rises from place `left` to 1 at `knot` and falls to 0 at `right`, all of one side, |left| < |knot| < |right|.
Feature tent(const Control& control, std::uint32_t index, double left, double knot, double right);

// Fits, on each side, straight pieces between as few of the sampled places as the tolerance allows, or a polynomial of
// fewer shapes; one polynomial for both sides if that is fewer still. A curve that is made of straight pieces is held
// to a hundredth of the tolerance where that takes at most two more knots. Straight pieces are stored as the chord and
// what each further knot adds to the pieces before it, so vertices that move straight are in one shape only.
ControlCurve fit_curve(const Control& control, const CurveSamples& samples, const CurveLimits& limits);

// Places worth sampling next: where the lines left and right of a bent interval meet, rounded to a near simple
// fraction; its middle where they do not.
std::vector<double> bent_places(const CurveSamples& samples, const CurveLimits& limits);

}  // namespace fb::bake
