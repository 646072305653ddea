// Frames of facebaker_character.h in double precision.
#pragma once

#include <facebaker/facebaker_character.h>

#include <array>
#include <optional>
#include <span>

namespace fb::tool {

// The upper three rows of a 4 x 4 matrix, row after row.
using Frame = std::array<double, FB_FRAME_FLOATS>;

inline constexpr Frame identity_place = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

Frame to_frame(std::span<const float> numbers);
std::array<float, FB_FRAME_FLOATS> to_floats(const Frame& frame);
Frame product(const Frame& a, const Frame& b);
// Nothing where there is none, but for rounding.
std::optional<Frame> inverse(const Frame& frame);

}  // namespace fb::tool
