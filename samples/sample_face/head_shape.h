// The head as a smooth solid: what the skin is wrapped around.
#pragma once

#include "vec3.h"

namespace sample_face {

// Signed distance, roughly in centimetres (negative inside). Symmetric in x.
float head_distance(Vec3 p);
// Unit outward normal of the distance field.
Vec3 head_normal(Vec3 p);
// The point on the surface nearest to p, roughly.
Vec3 onto_head(Vec3 p);
// The first point of the surface on the ray from `from` (outside) along the unit vector `direction`.
Vec3 hit_head(Vec3 from, Vec3 direction);

}  // namespace sample_face
