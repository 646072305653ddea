#pragma once

#include <cstddef>
#include <vector>

#include "base/vector3.h"
#include "render/image.h"

namespace fb::tool {

// Which scalars have which colours.
struct ColourScale {
  float end = 1;             // the value at the end, and all above
  bool logarithmic = false;  // over three decades below the end: smaller values have the first colour

  // 0 to 1: where on the scale a value lies.
  float position(float value) const;
  // Values to be labelled, ascending from the first to the end.
  std::vector<float> ticks() const;
};

// Colour map of a scalar field: pale grey for the beginning of the scale over yellow and red to black-violet for its
// end. Lightness decreases monotonically, so that it also reads in grey. Linear RGB, 0 to 1.
Vector3 map_colour(float value, const ColourScale& scale);

// Colours of parts, told apart easily; the first twelve are different.
Rgb part_colour(std::size_t part);

// The smallest of 1, 2, 5 x 10^n at or above value, for the end of a scale; 1e-6 for anything smaller.
float round_scale(float value);

}  // namespace fb::tool
