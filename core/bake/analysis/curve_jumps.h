// Curves of one control that jump: steps, as features that are exact to the last bit of the control.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/analysis/activation_curve.h"

namespace fb::bake {

// Shorter jumps are not looked for: in units of CurveLimits::tolerance.
constexpr double least_jump = 5;

// 0 from rest to position `inside`, 1 from `outside` on, on one side of rest: |inside| < |outside|, the nearer the
// better. A hat without a falling side, which reaches 1 within a float's spacing if the two values are neighbours.
Feature step(const Control& control, std::uint32_t index, double inside, double outside);
bool is_step(const Feature& feature);

// Whether no value lies between those at two positions, inside nearer to rest, that a reader, which computes with
// offsets from rest, could tell from both; or as good as none.
bool touch(const Control& control, double inside, double outside);

// A jump, between two samples that touch.
struct Jump {
  double inside = 0, outside = 0;  // positions; inside is 0 where the curve jumps as it leaves rest
  std::vector<float> offsets;      // displacement outside minus inside
};

// The jumps among the samples by more than `least` at a vertex, rig units, from rest outwards, up after down.
std::vector<Jump> find_jumps(const Control& control, const CurveSamples& samples, double least);

// The samples without what the jumps add, and without the one outside of each jump: a continuous curve.
CurveSamples without_jumps(const CurveSamples& samples, std::span<const Jump> jumps);

// Positions to sample next: the middle of every interval that is at least four times as steep as the intervals on
// either side of it and where some vertex moves by more than `least`. Asked again with these samples, it closes in on
// jumps, and returns nothing once all are found. Each call halves intervals: 60 suffice.
std::vector<double> positions_to_bisect(const Control& control, const CurveSamples& samples, double least);

// Positions between rest and the ends, one in the middle of every stretch that jumps bound.
std::vector<double> plateau_middles(const Control& control, std::span<const Jump> jumps);

// A polyline through as few of the samples as keep all of them within `tolerance`, greedily from rest outwards: the
// positions of its knots, ascending, the last sample of each side among them.
std::vector<double> polyline_knots(const CurveSamples& samples, double tolerance);

}  // namespace fb::bake
