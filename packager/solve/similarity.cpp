#include "solve/similarity.h"

#include <Eigen/Dense>
#include <cmath>

namespace fb::tool {
namespace {

using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Vector3d wide(Vector3 v) {
  return {v.x, v.y, v.z};
}

Vector3 narrow(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

Matrix3 matrix_of(const Similarity& s) {
  return Eigen::Map<const Matrix3>(s.rotation.data());
}

Eigen::Vector3d translation_of(const Similarity& s) {
  return Eigen::Map<const Eigen::Vector3d>(s.translation.data());
}

Similarity similarity_of(const Matrix3& rotation, double scale, const Eigen::Vector3d& translation) {
  Similarity s;
  Eigen::Map<Matrix3>(s.rotation.data()) = rotation;
  s.scale = scale;
  Eigen::Map<Eigen::Vector3d>(s.translation.data()) = translation;
  return s;
}

// Horn's matrix N, of the sums of products of coordinates.
Eigen::Matrix4d quaternion_matrix(const Eigen::Matrix3d& s) {
  Eigen::Matrix4d n;
  n(0, 0) = s(0, 0) + s(1, 1) + s(2, 2);
  n(1, 1) = s(0, 0) - s(1, 1) - s(2, 2);
  n(2, 2) = s(1, 1) - s(0, 0) - s(2, 2);
  n(3, 3) = s(2, 2) - s(0, 0) - s(1, 1);
  n(0, 1) = n(1, 0) = s(1, 2) - s(2, 1);
  n(0, 2) = n(2, 0) = s(2, 0) - s(0, 2);
  n(0, 3) = n(3, 0) = s(0, 1) - s(1, 0);
  n(1, 2) = n(2, 1) = s(0, 1) + s(1, 0);
  n(1, 3) = n(3, 1) = s(2, 0) + s(0, 2);
  n(2, 3) = n(3, 2) = s(1, 2) + s(2, 1);
  return n;
}

}  // namespace

Vector3 Similarity::operator()(Vector3 point) const {
  return narrow(scale * (matrix_of(*this) * wide(point)) + translation_of(*this));
}

Vector3 Similarity::turned(Vector3 direction) const {
  return narrow(matrix_of(*this) * wide(direction));
}

Similarity Similarity::inverse() const {
  const Matrix3 back = matrix_of(*this).transpose();
  return similarity_of(back, 1 / scale, -(back * translation_of(*this)) / scale);
}

std::vector<float> Similarity::applied(std::span<const float> points) const {
  std::vector<float> moved(points.size());
  for (std::size_t i = 0; i < points.size() / 3; ++i) {
    const Vector3 p = (*this)(vector_at(points.data(), i));
    moved[3 * i] = p.x;
    moved[3 * i + 1] = p.y;
    moved[3 * i + 2] = p.z;
  }
  return moved;
}

Similarity after(const Similarity& second, const Similarity& first) {
  return similarity_of(matrix_of(second) * matrix_of(first), second.scale * first.scale,
                       second.scale * (matrix_of(second) * translation_of(first)) + translation_of(second));
}

std::optional<Similarity> align_pairs(std::span<const PointPair> pairs, std::optional<double> scale) {
  if (pairs.size() < 3) return std::nullopt;
  Eigen::Vector3d from_mean = Eigen::Vector3d::Zero(), to_mean = Eigen::Vector3d::Zero();
  double sum = 0;
  for (const PointPair& pair : pairs) {
    from_mean += pair.weight * wide(pair.from);
    to_mean += pair.weight * wide(pair.to);
    sum += pair.weight;
  }
  if (!(sum > 0)) return std::nullopt;
  from_mean /= sum;
  to_mean /= sum;
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();
  double from_spread = 0, to_spread = 0;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d from = wide(pair.from) - from_mean, to = wide(pair.to) - to_mean;
    products += pair.weight * from * to.transpose();
    from_spread += pair.weight * from.squaredNorm();
    to_spread += pair.weight * to.squaredNorm();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(quaternion_matrix(products));
  const Eigen::Vector4d& values = solver.eigenvalues();  // ascending
  // Points on a line leave the rotation round it open: the two largest eigenvalues are equal.
  const double scale_of_values = std::sqrt(from_spread * to_spread);
  if (!(values(3) - values(2) > 1e-9 * scale_of_values)) return std::nullopt;
  const Eigen::Vector4d q = solver.eigenvectors().col(3);
  const Matrix3 rotation = Eigen::Quaterniond(q(0), q(1), q(2), q(3)).normalized().toRotationMatrix();
  const double ratio = scale ? *scale : std::sqrt(to_spread / from_spread);
  return similarity_of(rotation, ratio, to_mean - ratio * (rotation * from_mean));
}

Similarity plane_step(std::span<const PlanePair> pairs, bool fixed_scale) {
  using Vector7 = Eigen::Matrix<double, 7, 1>;
  if (pairs.empty()) return {};
  // Rotation and scale about the middle of the points, in units of their spread: the unknowns are of like size.
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const PlanePair& pair : pairs) middle += wide(pair.from) / static_cast<double>(pairs.size());
  double spread = 0;
  for (const PlanePair& pair : pairs) spread += (wide(pair.from) - middle).squaredNorm();
  spread = std::sqrt(spread / static_cast<double>(pairs.size()));
  if (!(spread > 0)) return {};
  Eigen::Matrix<double, 7, 7> normal_matrix = Eigen::Matrix<double, 7, 7>::Zero();
  Vector7 right = Vector7::Zero();
  for (const PlanePair& pair : pairs) {
    const Eigen::Vector3d arm = (wide(pair.from) - middle) / spread, n = wide(pair.normal);
    Vector7 row;
    row << arm.cross(n), n, fixed_scale ? 0.0 : arm.dot(n);
    const double off = n.dot(wide(pair.to) - wide(pair.from)) / spread;
    normal_matrix += pair.weight * row * row.transpose();
    right += pair.weight * off * row;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 7, 7>> solver(normal_matrix);
  Vector7 step = Vector7::Zero();
  const double least = 1e-7 * solver.eigenvalues()(6);
  for (int k = 0; k < 7; ++k) {
    const double value = solver.eigenvalues()(k);
    if (value > least) step += solver.eigenvectors().col(k) * (solver.eigenvectors().col(k).dot(right) / value);
  }
  const Eigen::Vector3d turn = step.head<3>();
  const double angle = turn.norm();
  Matrix3 rotation = Matrix3::Identity();
  if (angle > 0) rotation = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  const double scale = std::exp(step(6));
  const Eigen::Vector3d moved = middle + spread * step.segment<3>(3);
  return similarity_of(rotation, scale, moved - scale * (rotation * middle));
}

}  // namespace fb::tool
