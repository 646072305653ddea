// Vectors, motions and the smooth limits that the production rig is made of.
#pragma once

#include <algorithm>
#include <cmath>

namespace rigs::production {

struct Vec {
  float x = 0, y = 0, z = 0;
};

inline Vec operator+(Vec a, Vec b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec operator-(Vec a, Vec b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec operator*(Vec a, float s) {
  return {a.x * s, a.y * s, a.z * s};
}
inline Vec& operator+=(Vec& a, Vec b) {
  return a = a + b;
}
inline float dot(Vec a, Vec b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec cross(Vec a, Vec b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(Vec a) {
  return std::sqrt(dot(a, a));
}
inline Vec mix(Vec a, Vec b, float t) {
  return a + (b - a) * t;
}
inline float radians(float degrees) {
  return degrees * 0.0174532925f;
}

// A 3 x 3 matrix by rows.
struct Matrix {
  Vec rows[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
};

inline Vec operator*(const Matrix& m, Vec v) {
  return {dot(m.rows[0], v), dot(m.rows[1], v), dot(m.rows[2], v)};
}
inline Matrix operator*(const Matrix& a, const Matrix& b) {
  Matrix product;
  for (int i = 0; i < 3; ++i)
    product.rows[i] = b.rows[0] * a.rows[i].x + b.rows[1] * a.rows[i].y + b.rows[2] * a.rows[i].z;
  return product;
}

// Rotation about a unit axis, by Rodrigues' formula.
inline Matrix turn(Vec axis, float angle) {
  const float s = std::sin(angle), c = std::cos(angle), k = 1 - c;
  return {{{c + k * axis.x * axis.x, k * axis.x * axis.y - s * axis.z, k * axis.x * axis.z + s * axis.y},
           {k * axis.x * axis.y + s * axis.z, c + k * axis.y * axis.y, k * axis.y * axis.z - s * axis.x},
           {k * axis.x * axis.z - s * axis.y, k * axis.y * axis.z + s * axis.x, c + k * axis.z * axis.z}}};
}
// Rotation about x, then y, then z, in radians.
inline Matrix turn_xyz(float x, float y, float z) {
  return turn({0, 0, 1}, z) * turn({0, 1, 0}, y) * turn({1, 0, 0}, x);
}
// The least rotation that takes direction a to direction b, neither of them zero nor opposite.
inline Matrix turn_between(Vec a, Vec b) {
  const float la = length(a), lb = length(b);
  const Vec v = cross(a, b) * (1 / (la * lb));
  const float c = dot(a, b) / (la * lb), k = 1 / std::max(0.05f, 1 + c);
  return {{{c + k * v.x * v.x, k * v.x * v.y - v.z, k * v.x * v.z + v.y},
           {k * v.x * v.y + v.z, c + k * v.y * v.y, k * v.y * v.z - v.x},
           {k * v.x * v.z - v.y, k * v.y * v.z + v.x, c + k * v.z * v.z}}};
}

// Where a bone takes a point: `to` + matrix * (point - `from`).
struct Motion {
  Matrix matrix;
  Vec from, to;

  Vec operator()(Vec point) const { return to + matrix * (point - from); }
};

// First b, then a.
inline Motion operator*(const Motion& a, const Motion& b) {
  return {a.matrix * b.matrix, b.from, a(b.to)};
}

// x where it is small; never beyond `low` < 0 and `high` > 0.
inline float soft_limit(float x, float low, float high) {
  const float t = x / (x < 0 ? low : high), t2 = t * t;
  return x / std::sqrt(std::sqrt(1 + t2 * t2));
}
inline Vec soft_limit(Vec v, float reach) {
  const float t = dot(v, v) / (reach * reach);
  return v * (1 / std::sqrt(std::sqrt(1 + t * t)));
}
// max(0, x) with a corner rounded over `width`.
inline float soft_ramp(float x, float width) {
  return 0.5f * (x + std::sqrt(x * x + width * width));
}
inline float smoothstep(float from, float to, float x) {
  const float t = std::clamp((x - from) / (to - from), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}
// 1 at distance 0, 0 from `radius` on.
inline float bump(float distance, float radius) {
  const float t = 1 - distance * distance / (radius * radius);
  return t > 0 ? t * t : 0;
}

}  // namespace rigs::production
