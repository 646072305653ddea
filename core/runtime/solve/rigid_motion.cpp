#include "runtime/solve/rigid_motion.h"

#include <cmath>
#include <cstddef>

namespace fb::runtime {

RigidMotion RigidMotion::after(const std::array<double, 3>& vector, const std::array<double, 3>& by) const {
  const auto [w, x, y, z] = rotation;
  const double a = 0.5 * vector[0], b = 0.5 * vector[1], c = 0.5 * vector[2];
  RigidMotion next;
  next.rotation = {w - x * a - y * b - z * c, x + w * a + y * c - z * b, y + w * b + z * a - x * c,
                   z + w * c + x * b - y * a};
  double squares = 0;
  for (const double number : next.rotation) squares += number * number;
  for (double& number : next.rotation) number /= std::sqrt(squares);
  const std::array<double, 9> matrix = next.matrix();
  for (std::size_t axis = 0; axis < 3; ++axis)
    next.translation[axis] =
        translation[axis] + matrix[3 * axis] * by[0] + matrix[3 * axis + 1] * by[1] + matrix[3 * axis + 2] * by[2];
  return next;
}

// The quaternion by the largest of its elements (Shepperd, Journal of Guidance and Control 1, 1978).
std::optional<RigidMotion> RigidMotion::of_matrix(const float* rows) {
  const auto at = [&](std::size_t row, std::size_t column) { return double(rows[4 * row + column]); };
  const double trace = at(0, 0) + at(1, 1) + at(2, 2);
  const std::array<double, 4> squares = {trace, 2 * at(0, 0) - trace, 2 * at(1, 1) - trace, 2 * at(2, 2) - trace};
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i)
    if (squares[i] > squares[largest]) largest = i;
  const double x = at(2, 1) - at(1, 2), y = at(0, 2) - at(2, 0), z = at(1, 0) - at(0, 1);
  const double xy = at(0, 1) + at(1, 0), xz = at(0, 2) + at(2, 0), yz = at(1, 2) + at(2, 1);
  const double self = 1 + squares[largest];
  const std::array<double, 4> rows_of[4] = {{self, x, y, z}, {x, self, xy, xz}, {y, xy, self, yz}, {z, xz, yz, self}};
  RigidMotion motion;
  motion.rotation = rows_of[largest];
  double length = 0;
  for (const double number : motion.rotation) length += number * number;
  if (!(length > 1e-6)) return std::nullopt;
  for (double& number : motion.rotation) number /= std::sqrt(length);
  const std::array<double, 9> matrix = motion.matrix();
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      if (!(std::fabs(matrix[3 * row + column] - at(row, column)) < 1e-3)) return std::nullopt;
    motion.translation[row] = at(row, 3);
  }
  return motion;
}

void RigidMotion::write_matrix(float* rows) const {
  const std::array<double, 9> of = matrix();
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      rows[4 * row + column] = static_cast<float>(of[3 * row + column]);
    rows[4 * row + 3] = static_cast<float>(translation[row]);
  }
}

}  // namespace fb::runtime
