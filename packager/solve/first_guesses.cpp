#include "solve/first_guesses.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace fb::tool {
namespace {

Similarity rotation_of(const Eigen::Matrix3d& matrix) {
  Similarity s;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      s.rotation[static_cast<std::size_t>(3 * row + column)] = matrix(row, column);
  return s;
}

// Columns are the axes, of the least variance first. Nothing where two variances are alike within a tenth.
std::optional<Eigen::Matrix3d> principal_axes(std::span<const Vector3> points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Vector3 p : points) mean += Eigen::Vector3d(p.x, p.y, p.z) / static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vector3 p : points) {
    const Eigen::Vector3d d = Eigen::Vector3d(p.x, p.y, p.z) - mean;
    covariance += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const Eigen::Vector3d& v = solver.eigenvalues();
  constexpr double alike = 0.9;
  if (!(v(0) < alike * v(1)) || !(v(1) < alike * v(2))) return std::nullopt;
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  return axes;
}

std::vector<Vector3> moved_by(const Similarity& s, std::span<const Vector3> points) {
  std::vector<Vector3> moved;
  for (const Vector3 p : points) moved.push_back(s(p));
  return moved;
}

Similarity shifted(Similarity s, Vector3 by) {
  s.translation[0] += by.x;
  s.translation[1] += by.y;
  s.translation[2] += by.z;
  return s;
}

}  // namespace

std::vector<Similarity> axis_rotations() {
  std::vector<Similarity> rotations;
  std::array<int, 3> axes = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
      for (int row = 0; row < 3; ++row) matrix(row, axes[static_cast<std::size_t>(row)]) = (signs >> row & 1) ? -1 : 1;
      if (matrix.determinant() > 0) rotations.push_back(rotation_of(matrix));
    }
  } while (std::next_permutation(axes.begin(), axes.end()));
  return rotations;
}

std::vector<Similarity> principal_rotations(std::span<const Vector3> from, std::span<const Vector3> to) {
  const auto from_axes = principal_axes(from), to_axes = principal_axes(to);
  std::vector<Similarity> rotations;
  if (!from_axes || !to_axes) return rotations;
  for (const auto& [a, b, c] : {std::array{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}})
    rotations.push_back(rotation_of(*to_axes * Eigen::Vector3d(a, b, c).asDiagonal() * from_axes->transpose()));
  return rotations;
}

std::vector<Similarity> guesses_by_box(const std::vector<Similarity>& rotations, std::span<const Vector3> points,
                                       const BoundingBox& face, std::optional<double> scale) {
  const BoundingBox unturned = box_of(points);
  const double by_size = length(face.high - face.low) / length(unturned.high - unturned.low);
  std::vector<double> scales = {by_size, 0.6 * by_size, 1.6 * by_size};
  if (scale) scales = {*scale};
  std::vector<Similarity> guesses;
  for (Similarity guess : rotations)
    for (const double tried : scales) {
      guess.scale = tried;
      const BoundingBox box = box_of(moved_by(guess, points));
      const Vector3 middle = (face.low + face.high - box.low - box.high) * 0.5f;
      const Vector3 high = face.high - box.high, low = face.low - box.low;
      guesses.push_back(shifted(guess, middle));
      for (const Vector3 end : {high, low}) {
        guesses.push_back(shifted(guess, {end.x, middle.y, middle.z}));
        guesses.push_back(shifted(guess, {middle.x, end.y, middle.z}));
        guesses.push_back(shifted(guess, {middle.x, middle.y, end.z}));
      }
    }
  return guesses;
}

std::vector<Similarity> guesses_in_front(const std::vector<Similarity>& rotations, std::span<const Vector3> points,
                                         const BoundingBox& face, const std::string& up_axis, double scale) {
  const bool z_up = up_axis == "z";
  std::vector<Similarity> guesses;
  for (Similarity guess : rotations) {
    guess.scale = scale;
    const BoundingBox box = box_of(moved_by(guess, points));
    const Vector3 middle = (face.low + face.high - box.low - box.high) * 0.5f;
    for (const float height : {0.35f, 0.5f, 0.65f}) {
      Vector3 by = middle;
      if (z_up) {
        by.y = face.low.y - box.low.y;
        by.z = face.low.z + height * (face.high.z - face.low.z) - 0.5f * (box.low.z + box.high.z);
      } else {
        by.z = face.high.z - box.high.z;
        by.y = face.low.y + height * (face.high.y - face.low.y) - 0.5f * (box.low.y + box.high.y);
      }
      guesses.push_back(shifted(guess, by));
    }
  }
  return guesses;
}

double degrees_apart(const Similarity& a, const Similarity& b) {
  double trace = 0;
  for (std::size_t i = 0; i < 9; ++i) trace += a.rotation[i] * b.rotation[i];
  return std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0)) * 180 / std::numbers::pi;
}

}  // namespace fb::tool
