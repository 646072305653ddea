#include "runtime/solve/cholesky.h"

#include <algorithm>
#include <cmath>

namespace fb::runtime {
namespace {

std::size_t in_whole_vectors(std::size_t count) {
  return (count + padding - 1) / padding * padding;
}

}  // namespace

Cholesky::Cholesky(std::size_t most, const PoseKernels& kernels, std::pmr::memory_resource& memory)
    : kernels_(kernels),
      stride_(in_whole_vectors(most)),
      factor_(stride_ * stride_, &memory),
      inverses_(stride_, &memory),
      transposed_(stride_ * padding, &memory) {}

bool Cholesky::factorise(std::size_t count) {
  count_ = count;
  // What is right of the last column is multiplied with the rest.
  const std::size_t length = in_whole_vectors(count);
  for (std::size_t i = 0; i < count; ++i)
    std::fill(factor_.begin() + std::ptrdiff_t(i * stride_ + count),
              factor_.begin() + std::ptrdiff_t(i * stride_ + length), 0.0f);
  for (std::size_t first = 0; first < count; first += padding) {
    const std::size_t rows = std::min(padding, count - first);
    if (!factorise_panel(first, rows)) return false;
    subtract_panel(first, rows);
  }
  return true;
}

// The rows of a panel, of which the panels before have been subtracted.
bool Cholesky::factorise_panel(std::size_t first, std::size_t rows) {
  const std::size_t length = in_whole_vectors(count_) - first;
  float* const panel = factor_.data() + first * stride_ + first;  // its diagonal block comes first
  for (std::size_t i = 0; i < rows; ++i) {
    float* const row = panel + i * stride_;
    const float given = row[i];
    float factors[padding];
    for (std::size_t k = 0; k < i; ++k) factors[k] = -panel[k * stride_ + i];
    kernels_.add_rows(row, factors, panel, stride_, i, length);
    // A pivot of so little is rounding.
    if (!(row[i] > 1e-6f * given) || !(row[i] < 1e30f)) return false;
    const float inverse = 1.0f / std::sqrt(row[i]);
    inverses_[first + i] = inverse;
    for (std::size_t j = i; j < length; ++j) row[j] *= inverse;
    std::fill_n(row, i, 0.0f);
  }
  return true;
}

// From the rows below a panel, as many at a time.
void Cholesky::subtract_panel(std::size_t first, std::size_t rows) {
  const std::size_t end = in_whole_vectors(count_);
  for (std::size_t i = first + rows; i < count_; ++i)
    for (std::size_t k = 0; k < rows; ++k) transposed_[i * padding + k] = -factor_[(first + k) * stride_ + i];
  for (std::size_t i = first + rows; i < count_; i += padding) {
    const std::size_t below = std::min(padding, count_ - i);
    kernels_.add_products({factor_.data() + i * stride_ + i, stride_, below},
                          {transposed_.data() + i * padding, padding, below}, factor_.data() + first * stride_ + i,
                          stride_, rows, end - i);
  }
}

void Cholesky::solve(float* x) const {
  const std::size_t end = in_whole_vectors(count_);
  std::fill(x + count_, x + end, 0.0f);
  for (std::size_t i = 0; i < count_; ++i) {
    const std::size_t first = i / padding * padding;
    const float value = x[i] * inverses_[i], factor = -value;
    // A row's part left of the diagonal is 0.
    kernels_.add_rows(x + first, &factor, factor_.data() + i * stride_ + first, stride_, 1, end - first);
    x[i] = value;
  }
  for (std::size_t i = count_; i > 0; --i) {
    const std::size_t row = i - 1, first = row / padding * padding;
    const float right = x[row];
    x[row] = 0;
    float sum;
    kernels_.dot_products(x + first, factor_.data() + row * stride_ + first, stride_, 1, end - first, &sum);
    x[row] = (right - sum) * inverses_[row];
  }
}

// With A^-1 = U^-1 U^-T, element (c, c) is the squared length of column c of U^-T, found by forward substitution.
void Cholesky::inverse_diagonal(float* diagonal, float* work) const {
  const std::size_t end = in_whole_vectors(count_);
  for (std::size_t c = 0; c < count_; ++c) {
    std::fill_n(work, stride_, 0.0f);
    work[c] = 1;
    float squares = 0;
    for (std::size_t i = c; i < count_; ++i) {
      const std::size_t first = i / padding * padding;
      const float value = work[i] * inverses_[i], factor = -value;
      squares += value * value;
      kernels_.add_rows(work + first, &factor, factor_.data() + i * stride_ + first, stride_, 1, end - first);
    }
    diagonal[c] = squares;
  }
}

}  // namespace fb::runtime
