#include "bake/baselines/skinning/bone_fitter.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace fb::bake {
namespace {

// Bones smaller than this, over the diagonal, keep their orientation.
constexpr double min_extent = 1e-3;

using Position = Eigen::Matrix<double, 4, 1>;
using Transform = Eigen::Matrix<double, 3, 4>;

// The homogeneous position of a vertex relative to a bone: (v - centre, 1).
Position local_position(const Skeleton& skeleton, const Mesh& rest, std::size_t vertex, std::size_t bone) {
  Position x;
  for (int k = 0; k < 3; ++k) x[k] = double(rest.points[3 * vertex + k]) - skeleton.centres[bone][k];
  x[3] = 1;
  return x;
}

// The best rigid transform by weighted least squares, from the products of displacements with positions (3 x 4) and of
// positions with themselves (4 x 4).
Transform nearest_rigid(Transform targets, const Eigen::Matrix4d& positions, double stiffness) {
  targets += positions.topRows<3>();  // from displacements to positions
  const double mass = positions(3, 3);
  if (!(mass > 0)) return Transform::Zero();
  const Eigen::Vector3d from = positions.block<3, 1>(0, 3) / mass, to = targets.col(3) / mass;
  Eigen::Matrix3d cross = targets.leftCols<3>() - mass * to * from.transpose();
  cross.diagonal().array() += mass * stiffness;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  signs[2] = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  Transform result;
  result.leftCols<3>() = rotation - Eigen::Matrix3d::Identity();
  result.col(3) = to - rotation * from;
  return result;
}

}  // namespace

BoneFitter::BoneFitter(const Skeleton& skeleton, const Mesh& rest) : skeleton_(&skeleton), rest_(&rest) {
  const std::size_t bones = skeleton.bone_count();
  products_ = Eigen::MatrixXd::Zero(4 * bones, 4 * bones);
  single_products_ = Eigen::MatrixXd::Zero(4, 4 * bones);
  for (std::size_t v = 0; v < rest.vertex_count(); ++v)
    for (std::size_t i = 0; i < bones_per_vertex; ++i) {
      const double weight = skeleton.weights[v][i];
      if (weight == 0) continue;
      const std::size_t a = skeleton.bones[v][i];
      const Position x = local_position(skeleton, rest, v, a);
      single_products_.middleCols<4>(4 * a) += weight * x * x.transpose();
      for (std::size_t j = 0; j < bones_per_vertex; ++j)
        if (const std::size_t b = skeleton.bones[v][j]; skeleton.weights[v][j] != 0)
          products_.block<4, 4>(4 * a, 4 * b) +=
              weight * skeleton.weights[v][j] * x * local_position(skeleton, rest, v, b).transpose();
    }
  stiffness_ = std::pow(min_extent * rest.diagonal(), 2);
}

void BoneFitter::fit(std::span<const float> displacements, std::span<float> transforms, bool warm_start,
                     std::uint32_t sweeps) const {
  const std::size_t bones = skeleton_->bone_count();
  Eigen::Matrix<double, 3, Eigen::Dynamic> targets = Eigen::MatrixXd::Zero(3, 4 * bones), fitted = targets;
  for (std::size_t v = 0; v < rest_->vertex_count(); ++v) {
    const Eigen::Vector3d moved = Eigen::Map<const Eigen::Vector3f>(displacements.data() + 3 * v).cast<double>();
    if (moved.isZero(0)) continue;
    for (std::size_t i = 0; i < bones_per_vertex; ++i)
      if (const double weight = skeleton_->weights[v][i]; weight != 0) {
        const std::size_t b = skeleton_->bones[v][i];
        targets.middleCols<4>(4 * b) += weight * moved * local_position(*skeleton_, *rest_, v, b).transpose();
      }
  }
  using RowMajor = Eigen::Matrix<float, 3, 4, Eigen::RowMajor>;
  for (std::size_t b = 0; b < bones; ++b)
    fitted.middleCols<4>(4 * b) =
        warm_start ? Eigen::Map<const RowMajor>(transforms.data() + 12 * b).cast<double>()
                   : nearest_rigid(targets.middleCols<4>(4 * b), single_products_.middleCols<4>(4 * b), stiffness_);
  for (std::uint32_t sweep = 0; sweep < sweeps; ++sweep)
    for (std::size_t b = 0; b < bones; ++b) {
      const Eigen::Matrix4d own = products_.block<4, 4>(4 * b, 4 * b);
      const Transform others = fitted * products_.middleCols<4>(4 * b) - fitted.middleCols<4>(4 * b) * own;
      fitted.middleCols<4>(4 * b) = nearest_rigid(targets.middleCols<4>(4 * b) - others, own, stiffness_);
    }
  for (std::size_t b = 0; b < bones; ++b)
    Eigen::Map<RowMajor>(transforms.data() + 12 * b) = fitted.middleCols<4>(4 * b).cast<float>();
}

}  // namespace fb::bake
