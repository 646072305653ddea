// Rotations and the vectors that say them: about the vector, by its length in radians.
#pragma once

#include <array>
#include <cstdint>

#include "model/joints.h"

namespace fb::bake {

using Axis = std::array<double, 3>;

inline double dot(const Axis& a, const Axis& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Without translation.
Frame<double> rotation_about(const Axis& vector);

// The vector that rotation_about() turns into a rotation, of at most a half turn. A translation is ignored.
Axis rotation_vector(const Frame<double>& rotation);

// The vector of what rotates by one vector, and then by another.
Axis turned_further(const Axis& first, const Axis& then);
// The vector of what is left of a rotation before it turns further by `then`: turned_further(it, then) is `whole`.
Axis turned_before(const Axis& whole, const Axis& then);

// The axes that a rotation turns about, the first turned about first; all three.
using AxisOrder = std::array<std::uint8_t, 3>;
inline constexpr std::array<AxisOrder, 6> axis_orders = {
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

// The Euler angles of a rotation vector, by axis, in radians: the second turned about is at most a quarter turn.
Axis euler_angles(const Axis& vector, const AxisOrder& order);
// The reverse.
Axis from_euler_angles(const Axis& angles, const AxisOrder& order);

}  // namespace fb::bake
