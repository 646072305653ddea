#pragma once

#include <cstddef>
#include <memory_resource>
#include <vector>

#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {

// Symmetric, positive definite systems of up to `most` equations, by Cholesky's factorisation A = U^T U (Golub and Van
// Loan, Matrix Computations, 4.2), `padding` rows at a time, as floats with sums in one order. Rows are row_stride()
// floats apart.
class Cholesky {
 public:
  Cholesky(std::size_t most, const PoseKernels& kernels, std::pmr::memory_resource& memory);

  std::size_t row_stride() const { return stride_; }

  // The matrix of `count` rows, whose upper triangle is to be filled; factorise() replaces it.
  float* matrix() { return factor_.data(); }
  // False where it is not positive definite in floats: no more may be called then.
  bool factorise(std::size_t count);
  // Replaces the right side by the solution; x: row_stride() floats.
  void solve(float* x) const;
  // Writes the diagonal of the inverse. work: row_stride() floats.
  void inverse_diagonal(float* diagonal, float* work) const;

 private:
  bool factorise_panel(std::size_t first, std::size_t rows);
  void subtract_panel(std::size_t first, std::size_t rows);

  const PoseKernels& kernels_;
  std::size_t stride_, count_ = 0;
  std::pmr::vector<float> factor_;      // upper triangle
  std::pmr::vector<float> inverses_;    // of the diagonal
  std::pmr::vector<float> transposed_;  // of a panel's rows, less than 0: by column, `padding` floats each
};

}  // namespace fb::runtime
