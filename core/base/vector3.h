// Vector arithmetic for rendering and measuring.
#pragma once

#include <cmath>
#include <cstddef>

namespace fb {

struct Vector3 {
  float x = 0, y = 0, z = 0;
};

inline Vector3 operator+(Vector3 a, Vector3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vector3 operator-(Vector3 a, Vector3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vector3 operator*(Vector3 a, float s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline Vector3 operator*(Vector3 a, Vector3 b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
inline float dot(Vector3 a, Vector3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vector3 cross(Vector3 a, Vector3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(Vector3 a) {
  return std::sqrt(dot(a, a));
}
// A null vector stays null.
inline Vector3 normalized(Vector3 a) {
  const float l = length(a);
  return l > 0 ? a * (1 / l) : a;
}
inline Vector3 mix(Vector3 a, Vector3 b, float t) {
  return a + (b - a) * t;
}
// Angle between two vectors, in degrees; 0 if one is null.
inline double degrees_between(Vector3 a, Vector3 b) {
  constexpr double per_radian = 57.29577951308232;
  return std::atan2(double(length(cross(a, b))), double(dot(a, b))) * per_radian;
}
inline Vector3 vector_at(const float* points, std::size_t vertex) {
  return {points[3 * vertex], points[3 * vertex + 1], points[3 * vertex + 2]};
}

}  // namespace fb
