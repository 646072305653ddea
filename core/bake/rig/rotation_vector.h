// Rotations and the vectors that say them: about the vector, by its length in radians.
#pragma once

#include <array>

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

}  // namespace fb::bake
