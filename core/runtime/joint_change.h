// What a driven joint adds to the axes and the origin of space, of its numbers: EVALUATION.md, "Driven joints", whose
// order of operations this is. For floats, and for numbers that carry a derivative.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "model/driven_joints.h"
#include "model/joint_rotation.h"

namespace fb::runtime {

// Row after row: what is added to the three axes, and to the origin.
template <class Number>
using Change = std::array<Number, 12>;

template <class Number>
Number horner(const RotationPolynomial& coefficients, Number x) {
  Number sum = Number(coefficients[0]);
  for (std::size_t i = 1; i < coefficients.size(); ++i) sum = sum * x + Number(coefficients[i]);
  return sum;
}

// The axes at rest by numbers: a0 n[0] + a1 n[1] + a2 n[2].
template <class Number>
std::array<Number, 3> along_axes(const Frame<float>& rest, const Number* n) {
  std::array<Number, 3> sum;
  for (std::size_t a = 0; a < 3; ++a)
    sum[a] = (Number(rest[4 * a]) * n[0] + Number(rest[4 * a + 1]) * n[1]) + Number(rest[4 * a + 2]) * n[2];
  return sum;
}

// The rotation about a vector, less the identity.
template <class Number>
void rotate(const std::array<Number, 3>& v, Change<Number>& to) {
  const auto& [x, y, z] = v;
  const Number most = Number(most_squared_angle);
  const Number square = (x * x + y * y) + z * z, angle = square < most ? square : most;
  const Number s = horner(rotation_sine, angle), c = horner(rotation_cosine, angle);
  to[0] = -c * (y * y + z * z);
  to[5] = -c * (x * x + z * z);
  to[10] = -c * (x * x + y * y);
  const Number xy = c * (x * y), xz = c * (x * z), yz = c * (y * z);
  to[1] = xy - s * z;
  to[2] = xz + s * y;
  to[4] = xy + s * z;
  to[6] = yz - s * x;
  to[8] = xz - s * y;
  to[9] = yz + s * x;
}

// (a0 b[column]) + (a1 b[4 + column]) + (a2 b[8 + column]) of row a.
template <class Number, class Numbers>
Number times(const Number* row, const Numbers& b, std::size_t column) {
  return (row[0] * Number(b[column]) + row[1] * Number(b[4 + column])) + row[2] * Number(b[8 + column]);
}

// Rotates by what is there already, then about a vector: (outer + rotation) + outer x rotation.
template <class Number>
void turn_further(const std::array<Number, 3>& v, Change<Number>& to) {
  Change<Number> outer = {};
  rotate(v, outer);
  const Change<Number> rotation = to;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b)
      to[4 * a + b] = (outer[4 * a + b] + rotation[4 * a + b]) + times(&outer[4 * a], rotation, b);
}

// What lengthens the axes at rest, and then rotates: (rotation + lengthening) + rotation x lengthening.
template <class Number>
void lengthen(const Frame<float>& rest, const Number* n, Change<Number>& to) {
  Change<Number> lengths = {};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      const float *const row = &rest[4 * a], *const other = &rest[4 * b];
      lengths[4 * a + b] =
          (n[0] * Number(row[0] * other[0]) + n[1] * Number(row[1] * other[1])) + n[2] * Number(row[2] * other[2]);
    }
  const Change<Number> rotation = to;
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b)
      to[4 * a + b] = (rotation[4 * a + b] + lengths[4 * a + b]) + times(&rotation[4 * a], lengths, b);
}

// Of a joint without regard to its parent. which: the numbers it has; outer: those of each of its outer rotations.
// next(): its numbers in turn, those of the joint before those of outer rotations.
template <class Number, class Next>
Change<Number> change_of_joint(const Frame<float>& rest, std::uint32_t which, std::span<const std::uint8_t> outer,
                               const Next& next) {
  const auto take = [&](std::uint32_t left, Number* numbers) {
    for (; left != 0; left &= left - 1) numbers[std::countr_zero(left)] = next();
  };
  Number numbers[numbers_a_joint] = {};
  take(which, numbers);
  Change<Number> change = {};
  rotate(along_axes(rest, numbers), change);
  for (const std::uint8_t rotation : outer) {
    Number vector[3] = {};
    take(rotation, vector);
    if (vector[0] != Number(0.0f) || vector[1] != Number(0.0f) || vector[2] != Number(0.0f))
      turn_further(along_axes(rest, vector), change);
  }
  std::array<Number, 3> moved = along_axes(rest, numbers + 3);
  if (which & joint_pivot) {
    const std::array<Number, 3> pivot = along_axes(rest, numbers + 9);
    for (std::size_t a = 0; a < 3; ++a)
      moved[a] = moved[a] - ((change[4 * a] * pivot[0] + change[4 * a + 1] * pivot[1]) + change[4 * a + 2] * pivot[2]);
  }
  if (which & joint_scale) lengthen(rest, numbers + 6, change);
  const Number origin[3] = {Number(rest[3]), Number(rest[7]), Number(rest[11])};
  for (std::size_t a = 0; a < 3; ++a) {
    const Number* const row = &change[4 * a];
    change[4 * a + 3] = moved[a] - ((row[0] * origin[0] + row[1] * origin[1]) + row[2] * origin[2]);
  }
  return change;
}

// That of a joint whose parent does `above`: (above + own) + above x own.
template <class Number>
Change<Number> below_parent(const Change<Number>& above, const Change<Number>& own) {
  Change<Number> both;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column)
      both[4 * row + column] = (above[4 * row + column] + own[4 * row + column]) + times(&above[4 * row], own, column);
  return both;
}

}  // namespace fb::runtime
