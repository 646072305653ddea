#include "bake/basis/pca.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>

#include "bake/linalg/gemm.h"
#include "base/random.h"
#include "base/status.h"

namespace fb {
namespace {

using Matrix = Eigen::MatrixXf;  // column-major: a column is a pose or a component

constexpr std::size_t block_poses = 256;
constexpr std::size_t sample_poses = 1024;
constexpr std::size_t tile = 1024;  // rows of a product one worker makes at a time

// Runs body(first, count) over [0, total) in fixed pieces.
void tiles(const Parallel& parallel, std::size_t total, std::size_t size,
           const std::function<void(std::size_t, std::size_t)>& body) {
  parallel_for(parallel, (total + size - 1) / size,
               [&](std::size_t i, std::size_t) { body(i * size, std::min(size, total - i * size)); });
}

// Calls visit(first pose, rows x n) block after block.
void for_blocks(const PoseRows& poses, const Parallel& parallel, Progress& progress,
                const std::function<void(std::size_t, const Matrix&)>& visit) {
  const std::size_t rows = poses.rows();
  Matrix block(rows, std::min(block_poses, poses.size()));
  for (std::size_t first = 0; first < poses.size(); first += block_poses) {
    const std::size_t count = std::min(block_poses, poses.size() - first);
    block.resize(rows, count);
    poses.read(first, count, std::span(block.data(), rows * count), parallel);
    visit(first, block);
    progress.step(first + count);
  }
}

// subspace^T * block, one column a pose.
void project(const Matrix& subspace, const Matrix& block, float* out, const Parallel& parallel) {
  tiles(parallel, subspace.cols(), 64, [&](std::size_t first, std::size_t count) {
    gemm(Op::transposed, Op::plain, count, block.cols(), subspace.rows(), subspace.data() + first * subspace.rows(),
         subspace.rows(), block.data(), block.rows(), 0, out + first, subspace.cols());
  });
}

struct Spectrum {
  Matrix vectors;  // by falling value
  Eigen::VectorXd values;
};

Spectrum symmetric_spectrum(const Eigen::MatrixXd& gram) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  if (solver.info() != Eigen::Success)
    fail(Status::internal, "the eigenvalues of the poses' covariance do not converge");
  return {solver.eigenvectors().rowwise().reverse().cast<float>(), solver.eigenvalues().reverse().cwiseMax(0.0)};
}

// How many leading values sum to the target; all of them if they do not.
std::size_t count_reaching(const Eigen::VectorXd& values, double target) {
  double sum = 0;
  for (Eigen::Index k = 0; k < values.size(); ++k)
    if ((sum += values[k]) >= target) return k + 1;
  return values.size();
}

// Inner products of the columns, in double.
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

// Orthonormal columns that span nearly what the poses span: from the sample's own components, filled up with noise.
Matrix starting_subspace(const PoseRows& poses, double fraction, const Parallel& parallel, std::size_t& wanted) {
  const std::size_t rows = poses.rows(), samples = std::min(sample_poses, poses.size());
  Matrix points(rows, samples);
  for (std::size_t i = 0; i < samples; ++i)
    poses.read(i * poses.size() / samples, 1, std::span(points.col(i).data(), rows), parallel);
  Matrix inner(samples, samples);
  project(points, points, inner.data(), parallel);
  const Spectrum spectrum = symmetric_spectrum(inner.cast<double>());
  const double total = spectrum.values.sum();
  const std::size_t needed = total > 0 ? count_reaching(spectrum.values, fraction * total) : 1;
  wanted = std::min({needed + needed / 3 + 16, rows, poses.size()});
  Matrix start(rows, wanted);
  const std::size_t known = std::min<std::size_t>(wanted, samples);
  tiles(parallel, known, 16, [&](std::size_t first, std::size_t count) {
    gemm(Op::plain, Op::plain, rows, count, samples, points.data(), rows, spectrum.vectors.data() + first * samples,
         samples, 0, start.data() + first * rows, rows);
  });
  for (std::size_t k = 0; k < known; ++k) {
    const float norm = start.col(k).norm();
    if (norm > 0) start.col(k) /= norm;
  }
  return start.leftCols(known);
}

// Orthonormal basis of the columns; `width` columns, the missing ones drawn at random.
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

// One step of subspace iteration over all poses: sum of x (x^T subspace).
Matrix iterate(const PoseRows& poses, const Matrix& subspace, const Parallel& parallel, Progress& progress) {
  Matrix sum = Matrix::Zero(subspace.rows(), subspace.cols());
  Matrix weights(subspace.cols(), block_poses);
  for_blocks(poses, parallel, progress, [&](std::size_t, const Matrix& block) {
    project(subspace, block, weights.data(), parallel);
    tiles(parallel, sum.rows(), tile, [&](std::size_t row, std::size_t count) {
      gemm(Op::plain, Op::transposed, count, sum.cols(), block.cols(), block.data() + row, block.rows(), weights.data(),
           subspace.cols(), 1, sum.data() + row, sum.rows());
    });
  });
  return sum;
}

}  // namespace

PrincipalComponents principal_components(const PoseRows& poses, double fraction, const Parallel& parallel,
                                         Progress& progress) {
  const std::size_t rows = poses.rows();
  if (poses.size() == 0) fail(Status::bad_data, "there are no poses to find components of");
  std::size_t width = 0;
  Matrix subspace = starting_subspace(poses, fraction, parallel, width);
  for (;;) {
    subspace = orthonormal(subspace, width);
    progress.begin("finding blendshapes", poses.size());
    subspace = orthonormal(iterate(poses, subspace, parallel, progress), width);

    PrincipalComponents result;
    std::vector<float> projected(poses.size() * width);
    progress.begin("projecting poses", poses.size());
    double squares = 0;
    for_blocks(poses, parallel, progress, [&](std::size_t first, const Matrix& block) {
      project(subspace, block, projected.data() + first * width, parallel);
      for (Eigen::Index i = 0; i < block.cols(); ++i) squares += block.col(i).cast<double>().squaredNorm();
    });
    if (!(squares > 0)) fail(Status::bad_data, "no pose moves any vertex: there is nothing to bake");

    const Spectrum spectrum = symmetric_spectrum(gram_of(projected.data(), width, poses.size(), parallel));
    const double target = fraction * squares;
    const bool enough = spectrum.values.sum() >= target;
    if (!enough && width < std::min(rows, poses.size())) {
      width = std::min({width + width / 2 + 16, rows, poses.size()});
      continue;
    }
    result.rows = rows;
    result.count = count_reaching(spectrum.values, target);
    result.total = squares / poses.size();
    result.captured = spectrum.values.head(result.count).sum() / poses.size();
    result.components.resize(result.count * rows);
    tiles(parallel, rows, tile, [&](std::size_t row, std::size_t count) {
      gemm(Op::plain, Op::plain, count, result.count, width, subspace.data() + row, rows, spectrum.vectors.data(),
           width, 0, result.components.data() + row, rows);
    });
    result.coefficients.resize(poses.size() * result.count);
    tiles(parallel, poses.size(), tile, [&](std::size_t first, std::size_t count) {
      gemm(Op::transposed, Op::plain, result.count, count, width, spectrum.vectors.data(), width,
           projected.data() + first * width, width, 0, result.coefficients.data() + first * result.count, result.count);
    });
    return result;
  }
}

}  // namespace fb
