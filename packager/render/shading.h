// Shading of a surface point under lights that are fixed in camera space, so that a head turns in constant light.
#pragma once

#include "base/vector3.h"
#include "render/image.h"

namespace fb::tool {

// Radiance towards the camera, linear RGB. normal: unit, towards the camera; to_eye: unit; ambient_occlusion: see
// ambient_occlusion.h; colour: albedo, linear.
Vector3 shade_clay(Vector3 normal, Vector3 to_eye, float ambient_occlusion, Vector3 colour);
// Flatter light, under which colours can be compared with a colour bar.
Vector3 shade_colour_map(Vector3 normal, float ambient_occlusion, Vector3 colour);
// The background at height t of the image: 0 at the top, 1 at the bottom.
Vector3 background(float t);

// Albedo of a clay render.
inline constexpr Vector3 clay = {0.50f, 0.345f, 0.275f};

Vector3 from_srgb(Vector3 colour);
Rgb to_srgb(Vector3 linear);

}  // namespace fb::tool
