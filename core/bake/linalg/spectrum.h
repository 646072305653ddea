// What decompositions into components share. Not for headers that others include: it brings Eigen.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>

#include "base/parallel.h"

namespace fb::bake {

// Runs body(first, count) over [0, total) in pieces of `size`, which do not depend on the number of threads.
void tiles(const Parallel& parallel, std::size_t total, std::size_t size,
           const std::function<void(std::size_t, std::size_t)>& body);

struct Spectrum {
  Eigen::MatrixXf vectors;  // a column each, by falling value
  Eigen::VectorXd values;   // not negative
};

// Of a symmetric matrix without negative eigenvalues, such as a covariance.
Spectrum symmetric_spectrum(const Eigen::MatrixXd& gram);

// Inner products of the rows of a rows x count matrix, in double.
Eigen::MatrixXd gram_of(const float* columns, std::size_t rows, std::size_t count, const Parallel& parallel);

// Orthonormal basis of the columns, the first k of it spanning the first k; `width` columns, the missing ones drawn at
// random.
Eigen::MatrixXf orthonormal(const Eigen::MatrixXf& columns, std::size_t width);

}  // namespace fb::bake
