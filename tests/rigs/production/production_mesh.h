// The mesh of the production rig: a face with neck, lips, lids and a tongue, 854 vertices.
#pragma once

#include <cstdint>
#include <vector>

#include "production/rig_math.h"

namespace rigs::production {

// What a vertex belongs to; bones of one lip or lid leave the other alone.
enum class Part : std::uint8_t { skin, upper_lip, lower_lip, upper_lid, lower_lid, tongue };

struct FaceMesh {
  std::vector<Vec> points;
  std::vector<Part> parts;
  std::vector<std::int32_t> corners;  // four a face
};

constexpr Vec mouth_centre{0, -5.2f, 0};
constexpr float mouth_half_width = 2.5f, teeth_half_width = 3.2f, teeth_depth = 3.6f, teeth_centre_z = 4.6f;
constexpr Vec head_centre{0, 0, -1}, head_radii{7.6f, 11, 9.6f};

// Centre of the eyeball of a side.
inline Vec eye_centre(int side) {
  return {3.0f * static_cast<float>(side), 1.2f, 6.0f};
}
// The skin at x, y in front of the head.
Vec skin_at(float x, float y);

FaceMesh make_face_mesh();

}  // namespace rigs::production
