// Light on a surface point: a small photographer's studio in camera space, so that a head turns in fixed light.
#pragma once

#include "base/vector3.h"
#include "render/image.h"

namespace fb {

// Light that leaves a point towards the camera, linear. normal: unit, towards the camera; to_eye: unit;
// ambient_occlusion: of ambient_occlusion.h; colour: the surface's own, linear.
Vector3 shade_clay(Vector3 normal, Vector3 to_eye, float ambient_occlusion, Vector3 colour);
// Flatter light that leaves the colour readable against a scale.
Vector3 shade_map(Vector3 normal, float ambient_occlusion, Vector3 colour);
// The backdrop at height t, 0 at the top and 1 at the bottom of the picture.
Vector3 backdrop(float t);

// The clay a face is shown in.
inline constexpr Vector3 clay = {0.50f, 0.345f, 0.275f};

Vector3 from_srgb(Vector3 colour);
Rgb to_srgb(Vector3 linear);

}  // namespace fb
