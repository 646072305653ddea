#include "bake/baselines/skinning/linear_transforms.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>

namespace fb::bake {
namespace {

constexpr double stiffness =
    1e-6;  // over the mean of the diagonal: keeps bones of almost no extent from large matrices

// weight x (v - centre, 1) of every vertex: vertices x 4 bones.
Eigen::MatrixXd local_positions(const Skeleton& skeleton, const Mesh& rest) {
  Eigen::MatrixXd columns =
      Eigen::MatrixXd::Zero(Eigen::Index(skeleton.bones.size()), Eigen::Index(4 * skeleton.bone_count()));
  for (std::size_t v = 0; v < skeleton.bones.size(); ++v)
    for (std::size_t i = 0; i < bones_per_vertex; ++i) {
      const std::size_t bone = skeleton.bones[v][i];
      const double weight = skeleton.weights[v][i];
      for (std::size_t k = 0; k < 4; ++k)
        columns(Eigen::Index(v), Eigen::Index(4 * bone + k)) +=
            weight * (k < 3 ? double(rest.points[3 * v + k]) - skeleton.centres[bone][k] : 1);
    }
  return columns;
}

// The matrices of one shape, those of the bones before each other: 4 bones x 3.
struct ShapeFit {
  Eigen::MatrixXd wanted;          // products of local positions with the shape
  std::vector<Eigen::Index> rows;  // of the bones that are kept, ascending
  Eigen::MatrixXd matrices;        // of these
  std::vector<double> motion;      // by kept bone: sum over vertices of squared motion
};

void solve(const Eigen::MatrixXd& products, ShapeFit& fit) {
  fit.motion.clear();
  if (fit.rows.empty()) return;
  Eigen::MatrixXd inner = products(fit.rows, fit.rows);
  inner.diagonal().array() += stiffness * products.diagonal().mean();
  fit.matrices = inner.ldlt().solve(fit.wanted(fit.rows, Eigen::all)).eval();
  for (Eigen::Index b = 0; b < Eigen::Index(fit.rows.size()); b += 4) {
    const auto own = fit.matrices.middleRows<4>(b);
    const Eigen::Index bone = fit.rows[std::size_t(b)];
    fit.motion.push_back((own.transpose() * products.block<4, 4>(bone, bone) * own).trace());
  }
}

// Drops the bones that move vertices less than `least`.
void drop(double least, ShapeFit& fit) {
  std::vector<Eigen::Index> kept;
  for (std::size_t b = 0; b < fit.motion.size(); ++b)
    if (fit.motion[b] >= least) kept.insert(kept.end(), &fit.rows[4 * b], &fit.rows[4 * b] + 4);
  fit.rows = std::move(kept);
}

}  // namespace

std::vector<float> fit_linear_transforms(const Skeleton& skeleton, const Mesh& rest, std::span<const float> shapes,
                                         double share, const Parallel& parallel) {
  const std::size_t rows = rest.points.size(), count = shapes.size() / rows, bones = skeleton.bone_count();
  const Eigen::MatrixXd columns = local_positions(skeleton, rest), products = columns.transpose() * columns;
  std::vector<ShapeFit> fits(count);
  const auto solve_all = [&] {
    parallel_for(parallel, count, [&](std::size_t s, std::size_t) { solve(products, fits[s]); });
  };
  parallel_for(parallel, count, [&](std::size_t s, std::size_t) {
    using Vectors = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
    const Eigen::Map<const Vectors> shape(shapes.data() + s * rows, Eigen::Index(rows / 3), 3);
    fits[s].wanted = columns.transpose() * shape.cast<double>();
    for (std::size_t row = 0; row < 4 * bones; ++row) fits[s].rows.push_back(Eigen::Index(row));
  });
  solve_all();
  for (double kept = 1; kept > share;) {
    kept = std::max(kept / 2, share);
    std::vector<double> motions;
    for (const ShapeFit& fit : fits) motions.insert(motions.end(), fit.motion.begin(), fit.motion.end());
    const auto staying = std::min(motions.size(), std::size_t(kept * double(count * bones)));
    if (staying == 0 || staying == motions.size()) continue;
    const auto least = motions.begin() + std::ptrdiff_t(staying - 1);
    std::nth_element(motions.begin(), least, motions.end(), std::greater<>());
    for (ShapeFit& fit : fits) drop(*least, fit);
    solve_all();
  }
  std::vector<float> transforms(count * skeleton.parameter_count());
  for (std::size_t s = 0; s < count; ++s)
    for (std::size_t i = 0; i < fits[s].rows.size(); ++i) {
      const auto bone = std::size_t(fits[s].rows[i]) / 4, k = std::size_t(fits[s].rows[i]) % 4;
      for (std::size_t axis = 0; axis < 3; ++axis)
        transforms[s * skeleton.parameter_count() + 12 * bone + 4 * axis + k] =
            static_cast<float>(fits[s].matrices(Eigen::Index(i), Eigen::Index(axis)));
    }
  return transforms;
}

}  // namespace fb::bake
