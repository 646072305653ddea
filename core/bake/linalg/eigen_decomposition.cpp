#include "bake/linalg/eigen_decomposition.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>

#include "bake/linalg/gemm.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {

using Matrix = Eigen::MatrixXf;

void parallel_tiles(const Parallel& parallel, std::size_t total, std::size_t tile,
                    const std::function<void(std::size_t, std::size_t)>& body) {
  parallel_for(parallel, (total + tile - 1) / tile,
               [&](std::size_t i, std::size_t) { body(i * tile, std::min(tile, total - i * tile)); });
}

EigenDecomposition decompose_symmetric(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  if (solver.info() != Eigen::Success)
    fail(Status::internal, "the eigenvalues of the poses' covariance do not converge");
  return {solver.eigenvectors().rowwise().reverse().cast<float>(), solver.eigenvalues().reverse().cwiseMax(0.0)};
}

Eigen::MatrixXd gram_matrix(const float* columns, std::size_t rows, std::size_t count, const Parallel& parallel) {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(rows, rows);
  constexpr std::size_t columns_per_product = 4096;  // in float; products are summed in double
  for (std::size_t first = 0; first < count; first += columns_per_product) {
    const std::size_t n = std::min(columns_per_product, count - first);
    Matrix part(rows, rows);
    parallel_tiles(parallel, rows, 64, [&](std::size_t column, std::size_t width) {
      gemm(Op::plain, Op::transposed, rows, width, n, columns + first * rows, rows, columns + first * rows + column,
           rows, 0, part.data() + column * rows, rows);
    });
    gram += part.cast<double>();
  }
  return gram;
}

Matrix orthonormalise(const Matrix& columns, std::size_t width) {
  Matrix full(columns.rows(), width);
  const std::size_t given = std::min<std::size_t>(columns.cols(), width);
  full.leftCols(given) = columns.leftCols(given);
  for (std::size_t k = given; k < width; ++k) {
    Random random = open_stream(0, Stream::subspace_start, k);
    for (Eigen::Index i = 0; i < full.rows(); ++i) full(i, k) = random.normal();
  }
  const Eigen::HouseholderQR<Matrix> qr(full);
  return qr.householderQ() * Matrix::Identity(full.rows(), width);
}

}  // namespace fb::bake
