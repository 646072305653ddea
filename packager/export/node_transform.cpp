#include "export/node_transform.h"

#include <algorithm>
#include <cmath>

namespace fb::tool {
namespace {

using Axis = std::array<double, 3>;

double product(const Axis& a, const Axis& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Axis perpendicular(const Axis& a, const Axis& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Axis without(const Axis& a, const Axis& unit) {
  const double along = product(a, unit);
  return {a[0] - along * unit[0], a[1] - along * unit[1], a[2] - along * unit[2]};
}

// Of unit length, or `otherwise` if it has none.
Axis unit_or(const Axis& a, const Axis& otherwise) {
  const double length = std::sqrt(product(a, a));
  return length > 0 ? Axis{a[0] / length, a[1] / length, a[2] / length} : otherwise;
}

// Of a rotation whose columns are x, y and z: the largest of the four numbers first, which the others are divided by.
std::array<double, 4> quaternion_of(const Axis& x, const Axis& y, const Axis& z) {
  const std::array<double, 4> squares = {1 + x[0] - y[1] - z[2], 1 - x[0] + y[1] - z[2], 1 - x[0] - y[1] + z[2],
                                         1 + x[0] + y[1] + z[2]};
  const auto largest = static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());
  const double xy = x[1] + y[0], yz = y[2] + z[1], zx = z[0] + x[2], wx = y[2] - z[1], wy = z[0] - x[2],
               wz = x[1] - y[0];
  const std::array<double, 4> rows[] = {
      {squares[0], xy, zx, wx}, {xy, squares[1], yz, wy}, {zx, yz, squares[2], wz}, {wx, wy, wz, squares[3]}};
  std::array<double, 4> q = rows[largest];
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& number : q) number /= length;
  return q;
}

}  // namespace

NodeTransform::NodeTransform(const Frame& frame) {
  const auto column = [&](std::size_t c) { return Axis{frame[c], frame[4 + c], frame[8 + c]}; };
  const Axis x = column(0), y = column(1), z = column(2);
  translation = column(3);
  // z first, so that a frame that is only scaled keeps its axes.
  const Axis unit_z = unit_or(z, unit_or(perpendicular(x, y), {0, 0, 1}));
  const Axis other = std::fabs(unit_z[0]) < 0.9 ? Axis{1, 0, 0} : Axis{0, 1, 0};
  const Axis unit_y =
      unit_or(without(y, unit_z), unit_or(perpendicular(unit_z, x), unit_or(perpendicular(unit_z, other), {0, 1, 0})));
  const Axis unit_x = perpendicular(unit_y, unit_z);
  rotation = quaternion_of(unit_x, unit_y, unit_z);
  const double length_x = std::sqrt(product(x, x)), length_y = std::sqrt(product(y, y)),
               length_z = std::sqrt(product(z, z));
  scale = {product(x, unit_x) < 0 ? -length_x : length_x, length_y, length_z};
  constexpr double tolerance = 1e-4;  // of the sines
  sheared = std::fabs(product(x, y)) > tolerance * length_x * length_y ||
            std::fabs(product(y, z)) > tolerance * length_y * length_z ||
            std::fabs(product(z, x)) > tolerance * length_z * length_x;
}

Frame NodeTransform::frame() const {
  const auto [x, y, z, w] = rotation;
  const double turn[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                             {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                             {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  Frame rows;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) rows[4 * row + column] = turn[row][column] * scale[column];
    rows[4 * row + 3] = translation[row];
  }
  return rows;
}

void NodeTrack::add_rotation(const std::array<double, 4>& rotation) {
  double towards = 0;
  for (std::size_t i = 0; i < 4 && !rotations.empty(); ++i)
    towards += rotation[i] * rotations[rotations.size() - 4 + i];
  std::array<float, 4> numbers;
  for (std::size_t i = 0; i < 4; ++i) numbers[i] = static_cast<float>(towards < 0 ? -rotation[i] : rotation[i]);
  rotations.insert(rotations.end(), numbers.begin(), numbers.end());
}

}  // namespace fb::tool
