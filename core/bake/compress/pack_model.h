// From float to whole numbers.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/compress/rate_distortion.h"
#include "model/face_model.h"
#include "model/packed_model.h"

namespace fb::bake {

struct PackOptions {
  int first_bits = 8, hidden_bits = 8, output_bits = 8;  // of weights; 2 to 8, or 16
  // What rounding the values of one basis column may move a coordinate when the coefficient has its typical size, over
  // the diagonal: columns that could move one further are wide.
  double basis_tolerance = 1e-5;
  std::vector<float> coefficient_sizes;  // typical size of each coefficient, see BlockwiseModel; empty: 1
  // Over D: columns that move the coordinates of a group less (root mean square) at the typical size leave it.
  double drop = 0;
  // Over D: basis values are rounded to no less than this when the coefficient has its typical size. One step wherever
  // a column lies is what archives pack best, and values are then rounded as rate_distortion_quantise does; 0: as fine
  // as 8 or 16 bits allow. Rest positions are rounded to a quarter of it or less, or to 2^-20 D.
  double step = 0;
  double step_lambda = bits_per_squared_step;  // see rate_distortion_quantise
};

// Weights: one scale a row. Basis: one scale a column of a row group; columns that are 0 on a whole group leave it.
// Magnitudes below 2^-100 become 0. Fails with invalid_argument on other bits than those or another number of sizes
// than coefficients, and as check(FaceModel) does.
PackedModel pack_model(const FaceModel& model, const PackOptions& options);

}  // namespace fb::bake
