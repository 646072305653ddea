#pragma once

#include "base/vector3.h"

namespace fb {

// Colours of a scalar field: pale grey for 0 over yellow and red to black-violet for `full` and above, falling steadily
// in lightness so that it also reads in grey.
Vector3 map_colour(float value, float full);  // linear light, 0 to 1

// The next of 1, 2, 5 x 10^n at or above value: a scale's end that reads well; 1e-6 for anything smaller.
float round_scale(float value);

}  // namespace fb
