#include "bake/baselines/pca.h"

#include <algorithm>

#include "bake/linalg/eigen_decomposition.h"
#include "bake/linalg/gemm.h"
#include "base/keep_asking.h"
#include "base/status.h"

namespace fb::bake {
namespace {

using Matrix = Eigen::MatrixXf;  // column-major: a column is a pose or a component

constexpr std::size_t poses_per_read = 256;
constexpr std::size_t subspace_poses = 1024;  // of the first subspace
constexpr std::size_t tile = 1024;          // rows of a product that one worker computes at a time

// subspace^T * block: one column of coefficients a pose.
void project(const Matrix& subspace, const float* block, std::size_t poses, float* out, const Parallel& parallel) {
  parallel_tiles(parallel, subspace.cols(), 64, [&](std::size_t first, std::size_t count) {
    gemm(Op::transposed, Op::plain, count, poses, subspace.rows(), subspace.data() + first * subspace.rows(),
         subspace.rows(), block, subspace.rows(), 0, out + first, subspace.cols());
  });
}

// The number of leading values whose sum reaches the target; all if it does not.
std::size_t count_reaching(const Eigen::VectorXd& values, double target) {
  double sum = 0;
  for (Eigen::Index k = 0; k < values.size(); ++k)
    if ((sum += values[k]) >= target) return k + 1;
  return values.size();
}

// The normalised components of a sample of the poses. `width` becomes the number of columns to search with.
Matrix initial_subspace(const PoseRows& poses, double fraction, const Parallel& parallel, Progress& progress,
                        std::size_t& width) {
  const std::unique_ptr<PoseRows> sample = poses.subsampled(subspace_poses);
  const std::size_t rows = poses.rows(), samples = sample->size();
  Matrix points(rows, samples);
  sample->read(0, samples, std::span(points.data(), points.size()), parallel);
  Matrix inner(samples, samples);
  project(points, points.data(), samples, inner.data(), parallel);
  const EigenDecomposition eigen = ask_during(progress, [&] { return decompose_symmetric(inner.cast<double>()); });
  const double total = eigen.values.sum();
  const std::size_t needed = total > 0 ? count_reaching(eigen.values, fraction * total) : 1;
  width = std::min({needed + needed / 3 + 16, rows, poses.size()});
  Matrix start(rows, width);
  const std::size_t known = std::min<std::size_t>(width, samples);
  parallel_tiles(parallel, known, 16, [&](std::size_t first, std::size_t count) {
    gemm(Op::plain, Op::plain, rows, count, samples, points.data(), rows, eigen.vectors.data() + first * samples,
         samples, 0, start.data() + first * rows, rows);
  });
  for (std::size_t k = 0; k < known; ++k) {
    const float norm = start.col(k).norm();
    if (norm > 0) start.col(k) /= norm;
  }
  return start.leftCols(known);
}

// One step of subspace iteration over all poses: sum of x (x^T subspace).
Matrix subspace_iteration(const PoseRows& poses, const Matrix& subspace, const Parallel& parallel, Progress& progress) {
  Matrix sum = Matrix::Zero(subspace.rows(), subspace.cols());
  Matrix weights(subspace.cols(), poses_per_read);
  for_blocks(poses, poses_per_read, parallel, progress, [&](std::size_t, std::size_t n, const float* block) {
    project(subspace, block, n, weights.data(), parallel);
    parallel_tiles(parallel, sum.rows(), tile, [&](std::size_t row, std::size_t count) {
      gemm(Op::plain, Op::transposed, count, sum.cols(), n, block + row, sum.rows(), weights.data(), subspace.cols(), 1,
           sum.data() + row, sum.rows());
    });
  });
  return sum;
}

}  // namespace

PrincipalComponents principal_components(const PoseRows& poses, double fraction, const Parallel& parallel,
                                         Progress& progress) {
  const std::size_t rows = poses.rows();
  if (poses.size() == 0) fail(Status::bad_data, "there are no poses to find principal components of");
  std::size_t width = 0;
  Matrix subspace = initial_subspace(poses, fraction, parallel, progress, width);
  const auto orthonormal = [&](const Matrix& columns) {
    return ask_during(progress, [&] { return orthonormalise(columns, width); });
  };
  for (;;) {  // wider each time, up to the number of rows or poses
    subspace = orthonormal(subspace);
    progress.begin(Phase::analysis, "finding blendshapes", poses.size());
    subspace = orthonormal(subspace_iteration(poses, subspace, parallel, progress));

    PrincipalComponents result;
    std::vector<float> projected(poses.size() * width);
    progress.begin(Phase::training, "projecting poses", poses.size());
    double squares = 0;
    for_blocks(poses, poses_per_read, parallel, progress, [&](std::size_t first, std::size_t n, const float* block) {
      project(subspace, block, n, projected.data() + first * width, parallel);
      const Eigen::Map<const Matrix> columns(block, rows, n);
      for (Eigen::Index i = 0; i < columns.cols(); ++i) squares += columns.col(i).cast<double>().squaredNorm();
    });
    if (!(squares > 0)) fail(Status::bad_data, "no pose moves any vertex: there is nothing to bake");

    const Eigen::MatrixXd gram = gram_matrix(projected.data(), width, poses.size(), parallel);
    const EigenDecomposition eigen = ask_during(progress, [&] { return decompose_symmetric(gram); });
    const double target = fraction * squares;
    const bool enough = eigen.values.sum() >= target;
    if (!enough && width < std::min(rows, poses.size())) {
      width = std::min({width + width / 2 + 16, rows, poses.size()});
      continue;
    }
    result.rows = rows;
    result.count = count_reaching(eigen.values, target);
    result.total = squares / poses.size();
    result.captured = eigen.values.head(result.count).sum() / poses.size();
    result.components.resize(result.count * rows);
    parallel_tiles(parallel, rows, tile, [&](std::size_t row, std::size_t count) {
      gemm(Op::plain, Op::plain, count, result.count, width, subspace.data() + row, rows, eigen.vectors.data(), width,
           0, result.components.data() + row, rows);
    });
    result.coefficients.resize(poses.size() * result.count);
    parallel_tiles(parallel, poses.size(), tile, [&](std::size_t first, std::size_t count) {
      gemm(Op::transposed, Op::plain, result.count, count, width, eigen.vectors.data(), width,
           projected.data() + first * width, width, 0, result.coefficients.data() + first * result.count, result.count);
    });
    return result;
  }
}

}  // namespace fb::bake
