// Quantisation of a float model.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/compress/rate_distortion.h"
#include "model/face_model.h"
#include "model/packed_model.h"

namespace fb::bake {

struct PackOptions {
  int first_bits = 8, hidden_bits = 8, output_bits = 8;  // of weights; 2 to 8, or 16
  // Error of a coordinate by rounding the values of one basis column when the coefficient has its typical size, over
  // the diagonal D: columns whose error in 8 bits could be larger are wide (16 bits).
  double basis_tolerance = 1e-5;
  std::vector<float> coefficient_sizes;  // typical size of each coefficient, see BlockwiseModel; empty: 1
  // Over D: columns that displace no coordinate of a row block this far at the typical size are left out of it. (A root
  // mean square over the block would drop what moves a few vertices far: the worst vertex of a pose is one of those.)
  double drop = 0;
  // Over D: smallest quantisation step of the basis values when the coefficient has its typical size. One step for all
  // of a column codes best; values are then quantised by rate_distortion_quantise. 0: the finest steps of 8 or 16 bits.
  // The step of rest positions is at most a quarter of it, or 2^-20 D.
  double step = 0;
  double step_lambda = bits_per_squared_step;  // see rate_distortion_quantise
  // Whether rate_distortion_quantise is called. Without, values are rounded to the nearest, which takes a tenth of the
  // time; which columns a row block has, and so what a pose reads, is the same.
  bool rate_distortion = true;
  // How much errors of normals count beside distances: where vertices lie more densely than usual, steps are smaller in
  // proportion to the power `normal_weight` of their spacing (see vertex_spacing). 0: steps are the same everywhere.
  double normal_weight = 0;
  // Coefficients in some poses, poses x columns, for RoundingCompensation; empty: none.
  std::vector<float> samples = {};
};

// Quantises a model. Weights have one scale per row; the basis has one per column of a row block, and columns that are
// 0 in a whole row block are left out of it. Magnitudes below 2^-100 become 0. Fails with invalid_argument on other
// numbers of bits, of coefficient sizes or of samples, and as check(FaceModel) does. The result does not depend on the
// number of threads.
PackedModel pack_model(const FaceModel& model, const PackOptions& options, const Parallel& parallel = {});

}  // namespace fb::bake
