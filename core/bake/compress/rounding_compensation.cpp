#include "bake/compress/rounding_compensation.h"

#include <Eigen/Dense>
#include <cmath>
#include <utility>

#include "bake/linalg/gemm.h"

namespace fb::bake {
namespace {

// Added to the diagonal of C: of each mean square of a coefficient so much of it, and so much of its squared typical
// size. By the first, errors are not moved into columns that follow by chance, where values are rounded so coarsely
// that many more of them would be other than 0. By the second, not into columns whose coefficients few of the poses
// use, and barely: the values would grow until those few poses come out well, and all others wrong in which these are
// large. Without it, four controls of a sample face at the ends of their ranges moved a vertex by 0.4 of the diagonal,
// where the rig does not (compact, 2,000 poses; `bench_worst_poses`); with more than 0.03 the error rose.
constexpr double ridge = 0.1, rare_ridge = 0.03;

// The rows of M without the diagonal, of coefficients in some poses, poses x columns, divided by `sizes`.
std::vector<float> unit_factors(const Eigen::MatrixXf& coefficients, const Eigen::VectorXd& sizes) {
  const Eigen::Index n = coefficients.cols();
  const auto columns = static_cast<std::size_t>(n), poses = static_cast<std::size_t>(coefficients.rows());
  Eigen::MatrixXf sums(n, n);
  gemm(Op::transposed, Op::plain, columns, columns, poses, coefficients.data(), poses, coefficients.data(), poses, 0,
       sums.data(), columns);
  Eigen::MatrixXd products = sums.cast<double>() / static_cast<double>(poses);
  products.diagonal() = products.diagonal().array() * (1 + ridge) + rare_ridge;
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
                                           std::span<const float> typical_sizes, const Parallel& parallel)
    : factors_(model.row_blocks.size()) {
  using RowMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMatrix> all(samples.data(), Eigen::Index(samples.size() / model.columns), model.columns);
  parallel_for(parallel, factors_.size(), [&](std::size_t b, std::size_t) {
    const auto& columns = model.row_blocks[b].columns;
    Eigen::MatrixXf coefficients(all.rows(), Eigen::Index(columns.size()));
    Eigen::VectorXd sizes(coefficients.cols());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const float size = typical_sizes.empty() ? 1 : typical_sizes[columns[c].column];
      sizes[Eigen::Index(c)] = size > 0 ? double(size) : 1;
    }
    // Pose by pose: a pose of a large face has a million coefficients, of which a block's lie together.
    for (Eigen::Index pose = 0; pose < all.rows(); ++pose)
      for (std::size_t c = 0; c < columns.size(); ++c)
        coefficients(pose, Eigen::Index(c)) =
            all(pose, Eigen::Index(columns[c].column)) / static_cast<float>(sizes[Eigen::Index(c)]);
    factors_[b] = unit_factors(coefficients, sizes);
  });
}

}  // namespace fb::bake
