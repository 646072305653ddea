// Rate-distortion optimised quantisation of the basis.
#pragma once

#include <vector>

#include "bake/compress/rounding_compensation.h"
#include "model/packed_model.h"

namespace fb::bake {

// The default lambda, in bits per squared quantisation step. At high rates one more bit divides the mean squared error,
// 1/12 of a squared step, by 4, so a bit is worth 2 ln 2 / 12 of a squared step, about 1 / 8.7. With 6 and a step of
// 5/6, the error is that of rounding to nearest with a step of 1, in 7 to 10 % fewer bytes.
inline constexpr double bits_per_squared_step = 6;

struct RateDistortionOptions {
  double lambda = bits_per_squared_step;
  std::vector<float> vertex_weights = {};              // by vertex: of its squared errors; empty: 1
  const RoundingCompensation* compensation = nullptr;  // null: columns are rounded independently
};

// Quantises the values of the basis again so that rate + lambda * distortion is least: the bits that the archive's
// coder takes, plus `lambda` bits per squared step of error. `exact`: for each row block, the values before rounding,
// in steps and in the order of PackedRowBlock::values. The model holds them rounded to nearest; a value moves by at
// most one from there, or with compensation from the nearest to its compensated value, and only if it stays less than
// a step from that. What is exactly 0 is not compensated: no column moves more vertices than before. Scales and columns
// do not change.
void rate_distortion_quantise(PackedModel& model, const std::vector<std::vector<float>>& exact,
                              const RateDistortionOptions& options);

}  // namespace fb::bake
