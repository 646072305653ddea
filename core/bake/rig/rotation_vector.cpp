#include "bake/rig/rotation_vector.h"

#include <algorithm>
#include <cmath>

namespace fb::bake {

Frame<double> rotation_about(const Axis& v) {
  const double squared = dot(v, v), angle = std::sqrt(squared);
  const double s = angle < 1e-4 ? 1 - squared / 6 : std::sin(angle) / angle;
  const double c = angle < 1e-4 ? 0.5 - squared / 24 : (1 - std::cos(angle)) / squared;
  const auto [x, y, z] = v;
  return {1 - c * (y * y + z * z), c * x * y - s * z,       c * x * z + s * y,       0,
          c * x * y + s * z,       1 - c * (x * x + z * z), c * y * z - s * x,       0,
          c * x * z - s * y,       c * y * z + s * x,       1 - c * (x * x + y * y), 0};
}

// By the quaternion, of which the largest component is found first.
Axis rotation_vector(const Frame<double>& r) {
  const double squares[4] = {1 + r[0] + r[5] + r[10], 1 + r[0] - r[5] - r[10], 1 - r[0] + r[5] - r[10],
                             1 - r[0] - r[5] + r[10]};  // of 2 w, 2 x, 2 y, 2 z
  const double rows[4][4] = {{squares[0], r[9] - r[6], r[2] - r[8], r[4] - r[1]},
                             {r[9] - r[6], squares[1], r[1] + r[4], r[2] + r[8]},
                             {r[2] - r[8], r[1] + r[4], squares[2], r[6] + r[9]},
                             {r[4] - r[1], r[2] + r[8], r[6] + r[9], squares[3]}};
  const double* q = rows[std::max_element(squares, squares + 4) - squares];
  const double sign = q[0] < 0 ? -1 : 1;
  const Axis v = {sign * q[1], sign * q[2], sign * q[3]};
  const double length = std::sqrt(dot(v, v));
  if (length == 0) return {};
  const double angle = 2 * std::atan2(length, sign * q[0]);
  return {v[0] * angle / length, v[1] * angle / length, v[2] * angle / length};
}

Axis turned_further(const Axis& first, const Axis& then) {
  return rotation_vector(product(rotation_about(then), rotation_about(first)));
}

Axis turned_before(const Axis& whole, const Axis& then) {
  return turned_further(whole, {-then[0], -then[1], -then[2]});
}

// Entries of the product of three rotations about axes, written out.
Axis euler_angles(const Axis& vector, const AxisOrder& order) {
  const auto [a, b, c] = order;
  const Frame<double> r = rotation_about(vector);
  const auto entry = [&](std::size_t row, std::size_t column) { return r[4 * row + column]; };
  const double sign = (a + 1) % 3 == b ? 1 : -1;
  Axis angles;
  angles[a] = std::atan2(sign * entry(c, b), entry(c, c));
  angles[b] = std::asin(std::clamp(-sign * entry(c, a), -1.0, 1.0));
  angles[c] = std::atan2(sign * entry(b, a), entry(a, a));
  return angles;
}

Axis from_euler_angles(const Axis& angles, const AxisOrder& order) {
  Axis vector = {};
  for (const std::size_t axis : order) {
    Axis one = {};
    one[axis] = angles[axis];
    vector = turned_further(vector, one);
  }
  return vector;
}

}  // namespace fb::bake
