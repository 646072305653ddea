#include "bake/linalg/spectrum.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>

#include "bake/linalg/gemm.h"
#include "base/random.h"
#include "base/status.h"

namespace fb::bake {

using Matrix = Eigen::MatrixXf;

void tiles(const Parallel& parallel, std::size_t total, std::size_t size,
           const std::function<void(std::size_t, std::size_t)>& body) {
  parallel_for(parallel, (total + size - 1) / size,
               [&](std::size_t i, std::size_t) { body(i * size, std::min(size, total - i * size)); });
}

Spectrum symmetric_spectrum(const Eigen::MatrixXd& gram) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  if (solver.info() != Eigen::Success)
    fail(Status::internal, "the eigenvalues of the poses' covariance do not converge");
  return {solver.eigenvectors().rowwise().reverse().cast<float>(), solver.eigenvalues().reverse().cwiseMax(0.0)};
}

Eigen::MatrixXd gram_of(const float* columns, std::size_t rows, std::size_t count, const Parallel& parallel) {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(rows, rows);
  constexpr std::size_t poses_at_once = 4096;
  for (std::size_t first = 0; first < count; first += poses_at_once) {
    const std::size_t n = std::min(poses_at_once, count - first);
    Matrix part(rows, rows);
    tiles(parallel, rows, 64, [&](std::size_t column, std::size_t width) {
      gemm(Op::plain, Op::transposed, rows, width, n, columns + first * rows, rows, columns + first * rows + column,
           rows, 0, part.data() + column * rows, rows);
    });
    gram += part.cast<double>();
  }
  return gram;
}

Matrix orthonormal(const Matrix& columns, std::size_t width) {
  Matrix full(columns.rows(), width);
  const std::size_t given = std::min<std::size_t>(columns.cols(), width);
  full.leftCols(given) = columns.leftCols(given);
  for (std::size_t k = given; k < width; ++k) {
    Random random(0x5eed, k);
    for (Eigen::Index i = 0; i < full.rows(); ++i) full(i, k) = random.normal();
  }
  const Eigen::HouseholderQR<Matrix> qr(full);
  return qr.householderQ() * Matrix::Identity(full.rows(), width);
}

}  // namespace fb::bake
