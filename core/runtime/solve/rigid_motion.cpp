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

}  // namespace fb::runtime
