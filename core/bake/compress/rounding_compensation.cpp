#include "bake/compress/rounding_compensation.h"

#include <Eigen/Dense>
#include <cmath>
#include <utility>

#include "bake/linalg/gemm.h"

namespace fb::bake {
namespace {

// Added to the diagonal of C, of coefficients whose mean square is 1: errors are not moved into columns that follow by
// chance, where values are rounded so coarsely that many more of them would be other than 0.
constexpr double ridge = 0.1;

// Divides the columns by their root mean square, and returns that; columns that are 0 stay so.
Eigen::VectorXd normalise(Eigen::MatrixXf& coefficients) {
  Eigen::VectorXd sizes(coefficients.cols());
  for (Eigen::Index c = 0; c < coefficients.cols(); ++c) {
    auto column = coefficients.col(c);
    sizes[c] = std::sqrt(column.cast<double>().squaredNorm() / static_cast<double>(column.size()));
    if (sizes[c] > 0) column = (column.cast<double>() / sizes[c]).cast<float>();
  }
  return sizes;
}

// The rows of M without the diagonal, of coefficients in some poses, poses x columns.
std::vector<float> unit_factors(Eigen::MatrixXf coefficients) {
  const Eigen::Index n = coefficients.cols();
  const Eigen::VectorXd sizes = normalise(coefficients);
  const auto columns = static_cast<std::size_t>(n), poses = static_cast<std::size_t>(coefficients.rows());
  Eigen::MatrixXf sums(n, n);
  gemm(Op::transposed, Op::plain, columns, columns, poses, coefficients.data(), poses, coefficients.data(), poses, 0,
       sums.data(), columns);
  Eigen::MatrixXd products = sums.cast<double>() / static_cast<double>(poses);
  products.diagonal().array() += ridge;
  // With the columns in reverse, C = L L^T gives M = L^T over its diagonal.
  const Eigen::LLT<Eigen::MatrixXd> decomposed(products.reverse());
  const Eigen::MatrixXd lower = decomposed.matrixL();
  std::vector<float> rows;
  rows.reserve(static_cast<std::size_t>(n * (n - 1) / 2));
  for (Eigen::Index d = 0; d < n; ++d)
    for (Eigen::Index c = 0; c < d; ++c) {
      const auto factor =
          static_cast<float>(lower(n - 1 - c, n - 1 - d) / lower(n - 1 - d, n - 1 - d) * sizes[c] / sizes[d]);
      rows.push_back(std::isfinite(factor) ? factor : 0);
    }
  return rows;
}

}  // namespace

RoundingCompensation::RoundingCompensation(const PackedModel& model, std::span<const float> samples,
                                           const Parallel& parallel)
    : factors_(model.row_blocks.size()) {
  using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMatrix> all(samples.data(), Eigen::Index(samples.size() / model.columns), model.columns);
  parallel_for(parallel, factors_.size(), [&](std::size_t b, std::size_t) {
    const auto& columns = model.row_blocks[b].columns;
    Eigen::MatrixXf coefficients(all.rows(), Eigen::Index(columns.size()));
    // Pose by pose: a pose of a large face has a million coefficients, of which a block's lie together.
    for (Eigen::Index pose = 0; pose < all.rows(); ++pose)
      for (std::size_t c = 0; c < columns.size(); ++c)
        coefficients(pose, Eigen::Index(c)) = all(pose, Eigen::Index(columns[c].column));
    factors_[b] = unit_factors(std::move(coefficients));
  });
}

}  // namespace fb::bake
