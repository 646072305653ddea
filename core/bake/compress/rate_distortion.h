// Rounding with an eye on what an archive makes of it.
#pragma once

#include <vector>

#include "model/packed_model.h"

namespace fb::bake {

// Rounds the numbers of the basis anew: of the whole numbers near a value that which costs least, where a square of a
// step of error costs as much as `bits_per_step` bits of the archive. `exact`: for each row group what its values are
// rounded from, in steps. No number comes to lie a whole step from what it stands for that was nearer before; scales
// and columns stay. Where a bit more would divide an error of 1/12 of a squared step by 4, one is worth 2 ln 2 / 12 of
// a squared step; a step of 5/6 rounded so gives the error of a whole one and 7 to 10 % fewer bytes.
inline constexpr double bits_per_squared_step = 6;
void rate_distortion_quantise(PackedModel& model, const std::vector<std::vector<float>>& exact, double bits_per_step);

}  // namespace fb::bake
