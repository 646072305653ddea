#pragma once

#include <cstddef>
#include <span>

#include "bake/analysis/curve_jumps.h"

namespace fb::bake {

constexpr std::size_t most_jumps = 64;  // of a control

// fit_curve for a control that jumps, or bends more often than max_knots: a step for each jump, and a curve through
// what is left of the samples. Of more than max_knots knots, that is a tent at each: up to 32 that keep to the
// tolerance or up to 256 that keep to five times as much. Without shapes if it takes more, or has more than most_jumps
// jumps.
ControlCurve fit_jumping_curve(const Control& control, const CurveSamples& samples, std::span<const Jump> jumps,
                               const CurveLimits& limits);

}  // namespace fb::bake
