// Where things are in the head: centimetres, y up, the face looks along +z, the character's left is +x.
#pragma once

#include "vec3.h"

namespace sample_face {

inline constexpr float kEyeRadius = 1.95f;
inline constexpr Vec3 kEyeCentre{3.4f, 0.0f, 5.9f};  // of the left eye
inline constexpr float kCorneaHeight = 0.17f;        // of the bulge over the eye's sphere, on the line of sight
inline constexpr float kCorneaAngle = radians(32);   // where the bulge ends, seen from the eye's centre
inline constexpr float kLidThickness = 0.17f;

inline constexpr float kMouthY = -7.1f;  // of the line between the lips
inline constexpr float kMouthHalfWidth = 2.75f;

inline constexpr Vec3 kJawHinge{0.0f, -2.6f, -0.6f};  // the axis runs along x

inline Vec3 eye_centre(int side) {
  return {kEyeCentre.x * float(side), kEyeCentre.y, kEyeCentre.z};
}

// Height of the cornea's bulge over the eye's sphere where the cosine to the line of sight is `cosine`; smooth.
inline float cornea_bulge(float cosine) {
  const float rim = 0.84804810f;  // cos(kCorneaAngle)
  const float t = (cosine - rim) / (1 - rim);
  return t > 0 ? kCorneaHeight * t * (2 - t) * smoothstep(0, 0.35f, t) : 0.0f;
}

}  // namespace sample_face
