#pragma once

#include <array>
#include <optional>

namespace fb::runtime {

// A rotation and then a translation.
struct RigidMotion {
  std::array<double, 4> rotation = {1, 0, 0, 0};  // a unit quaternion: w, x, y, z
  std::array<double, 3> translation = {};

  // Of a matrix of three rows and four columns; nothing where that is none of a rotation and a translation.
  static std::optional<RigidMotion> of_matrix(const float* rows);
  void write_matrix(float* rows) const;

  // The rotation, row after row.
  std::array<double, 9> matrix() const {
    const auto [w, x, y, z] = rotation;
    return {w * w + x * x - y * y - z * z, 2 * (x * y - w * z),           2 * (x * z + w * y),
            2 * (x * y + w * z),           w * w - x * x + y * y - z * z, 2 * (y * z - w * x),
            2 * (x * z - w * y),           2 * (y * z + w * x),           w * w - x * x - y * y + z * z};
  }
  // Rotates by a small rotation vector and moves by `by`, both in the space before the motion.
  RigidMotion after(const std::array<double, 3>& vector, const std::array<double, 3>& by) const;
};

}  // namespace fb::runtime
