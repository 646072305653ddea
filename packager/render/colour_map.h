#pragma once

#include "base/vector3.h"

namespace fb::tool {

// Colour map of a scalar field: pale grey for 0 over yellow and red to black-violet for scale_max and above. Lightness
// decreases monotonically, so that it also reads in grey. Linear RGB, 0 to 1.
Vector3 map_colour(float value, float scale_max);

// The smallest of 1, 2, 5 x 10^n at or above value, for the end of a scale; 1e-6 for anything smaller.
float round_scale(float value);

}  // namespace fb::tool
