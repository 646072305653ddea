// The little vector arithmetic the face is built and posed with.
#pragma once

#include <algorithm>
#include <cmath>

namespace sample_face {

struct Vec3 {
  float x = 0, y = 0, z = 0;

  Vec3& operator+=(Vec3 b) { return *this = {x + b.x, y + b.y, z + b.z}; }
  Vec3& operator-=(Vec3 b) { return *this = {x - b.x, y - b.y, z - b.z}; }
};

inline Vec3 operator+(Vec3 a, Vec3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(Vec3 a, Vec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(Vec3 a, float s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline Vec3 operator*(float s, Vec3 a) {
  return a * s;
}
inline Vec3 scale(Vec3 a, Vec3 b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
inline float dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(Vec3 a) {
  return std::sqrt(dot(a, a));
}
// Unit vector; the zero vector stays zero.
inline Vec3 unit(Vec3 a) {
  const float l = length(a);
  return l > 0 ? a * (1 / l) : a;
}
inline Vec3 mirrored(Vec3 a) {
  return {-a.x, a.y, a.z};
}
inline float mix(float a, float b, float t) {
  return a + (b - a) * t;
}
inline Vec3 mix(Vec3 a, Vec3 b, float t) {
  return a + (b - a) * t;
}
inline float clamp01(float t) {
  return std::clamp(t, 0.0f, 1.0f);
}
// 0 below a, 1 above b, smooth between.
inline float smoothstep(float a, float b, float x) {
  const float t = clamp01((x - a) / (b - a));
  return t * t * (3 - 2 * t);
}

inline constexpr float kPi = 3.14159265358979f;
inline constexpr float radians(float degrees) {
  return degrees * (kPi / 180);
}

}  // namespace sample_face
