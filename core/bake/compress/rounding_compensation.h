// Rounding errors of one column of the basis, made good by the columns after it.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "model/packed_model.h"

namespace fb::bake {

// Coefficients that are large in the same poses (the hats of one control, a corrective and its controls) share their
// errors: with e the rounding errors of a row's values and C the mean products of coefficients over poses, the mean
// squared error of a coordinate is e^T C e. With C = M^T D M, M unit lower triangular and D diagonal, that is the sum
// over columns d of D_d (e_d + sum over c < d of M_dc e_c)^2. So column d is rounded not from its exact value but from
// that minus the sum, column after column. This is Optimal Brain Compression (Frantar and Alistarh 2022, arXiv
// 2208.11580) for a whole matrix, in the form of its Cholesky factor.
class RoundingCompensation {
 public:
  // `samples`: coefficients in some poses, poses x model.columns. `typical_sizes`: of each coefficient where it is not
  // 0, see PackOptions; empty: 1. The columns of each row block must be final.
  RoundingCompensation(const PackedModel& model, std::span<const float> samples, std::span<const float> typical_sizes,
                       const Parallel& parallel);

  // M of a row block: row `index`, up to its diagonal. Of the columns by their index in the block.
  std::span<const float> factors(std::size_t block, std::size_t index) const {
    return std::span(factors_[block]).subspan(index * (index - 1) / 2, index);
  }

 private:
  std::vector<std::vector<float>> factors_;  // by row block: the rows of M one after the other
};

}  // namespace fb::bake
