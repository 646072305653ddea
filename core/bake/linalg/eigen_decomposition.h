// Dense linear algebra shared by PCA, local bases and blockwise PCA. It includes Eigen, so headers should not include it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>

#include "base/parallel.h"

namespace fb::bake {

// Runs body(first, count) on tiles of `tile` out of [0, total). Tiles do not depend on the number of threads.
void parallel_tiles(const Parallel& parallel, std::size_t total, std::size_t tile,
                    const std::function<void(std::size_t, std::size_t)>& body);

struct EigenDecomposition {
  Eigen::MatrixXf vectors;  // one column each, by falling eigenvalue
  Eigen::VectorXd values;   // not negative
};

// Of a symmetric positive semidefinite matrix such as a covariance. Fails with internal if it does not converge.
EigenDecomposition decompose_symmetric(const Eigen::MatrixXd& matrix);

// The Gram matrix of the rows of a rows x count matrix: rows x rows, summed in double.
Eigen::MatrixXd gram_matrix(const float* columns, std::size_t rows, std::size_t count, const Parallel& parallel);

// Orthonormalises columns by QR: the first k columns of the result span the first k given. The result has `width`
// columns; missing ones start as random vectors of a fixed seed.
Eigen::MatrixXf orthonormalise(const Eigen::MatrixXf& columns, std::size_t width);

}  // namespace fb::bake
