// Local controls: points of the face that move along x, y and z, laid out in rows and pairs.
#include "anatomy.h"
#include "shape_terms.h"

namespace sample_face {
namespace {

// One point. Sided points are given on the left and mirrored.
struct TweakPoint {
  const char* name;
  const char* group;
  bool sided;
  Vec3 centre, radius;
  float reach;  // cm at the end of the range
  const char* axes = "xyz";
  On on = On::all;
};

const TweakPoint kPoints[] = {
    {"brow_1", "brows", true, {1.0f, 2.6f, 8.4f}, {1.1f, 1.3f, 2}, 0.30f},
    {"brow_2", "brows", true, {2.1f, 2.9f, 8.2f}, {1.1f, 1.3f, 2}, 0.30f},
    {"brow_3", "brows", true, {3.2f, 3.0f, 7.8f}, {1.2f, 1.3f, 2}, 0.30f},
    {"brow_4", "brows", true, {4.3f, 2.9f, 7.0f}, {1.2f, 1.3f, 2}, 0.30f},
    {"brow_5", "brows", true, {5.3f, 2.5f, 6.0f}, {1.2f, 1.3f, 2}, 0.30f},
    {"brow_middle", "brows", false, {0, 2.5f, 8.6f}, {0.9f, 1.4f, 2}, 0.25f},
    {"forehead_low", "brows", true, {2.2f, 5.0f, 7.8f}, {2.2f, 1.7f, 3}, 0.25f, "yz"},
    {"forehead_high", "brows", true, {2.2f, 7.4f, 6.8f}, {2.4f, 2.0f, 3}, 0.25f, "yz"},
    {"temple", "brows", true, {6.1f, 3.2f, 3.8f}, {1.9f, 2.4f, 3}, 0.25f},
    {"socket_inner", "lids", true, {1.4f, 0.2f, 7.5f}, {0.9f, 1.2f, 1.5f}, 0.18f},
    {"socket_outer", "lids", true, {5.5f, 0.1f, 5.9f}, {1.0f, 1.3f, 1.8f}, 0.22f},
    {"under_eye_1", "lids", true, {4.6f, -2.0f, 7.0f}, {1.2f, 1.0f, 1.8f}, 0.2f},
    {"under_eye_2", "lids", true, {3.3f, -2.3f, 7.5f}, {1.2f, 1.0f, 1.8f}, 0.2f},
    {"under_eye_3", "lids", true, {2.1f, -2.0f, 7.8f}, {1.1f, 1.0f, 1.8f}, 0.2f},
    {"cheek_1", "cheeks", true, {2.8f, -3.6f, 7.8f}, {1.5f, 1.5f, 2.2f}, 0.3f},
    {"cheek_2", "cheeks", true, {4.3f, -3.3f, 7.0f}, {1.6f, 1.6f, 2.2f}, 0.3f},
    {"cheek_3", "cheeks", true, {5.7f, -3.0f, 5.4f}, {1.6f, 1.7f, 2.4f}, 0.3f},
    {"cheek_4", "cheeks", true, {4.1f, -5.4f, 6.8f}, {1.6f, 1.6f, 2.4f}, 0.32f},
    {"cheek_5", "cheeks", true, {5.5f, -5.4f, 5.0f}, {1.7f, 1.8f, 2.6f}, 0.32f},
    {"cheek_6", "cheeks", true, {4.5f, -7.6f, 6.0f}, {1.6f, 1.7f, 2.6f}, 0.32f},
    {"fold_1", "cheeks", true, {2.0f, -4.5f, 8.3f}, {0.9f, 0.9f, 1.6f}, 0.2f},
    {"fold_2", "cheeks", true, {2.8f, -5.5f, 8.0f}, {0.9f, 0.9f, 1.6f}, 0.2f},
    {"fold_3", "cheeks", true, {3.5f, -6.7f, 7.5f}, {0.9f, 0.9f, 1.6f}, 0.2f},
    {"nose_bridge", "nose", false, {0, 0.2f, 8.4f}, {0.9f, 1.3f, 1.6f}, 0.18f},
    {"nose_back", "nose", false, {0, -1.8f, 9.4f}, {0.9f, 1.2f, 1.6f}, 0.18f},
    {"nose_end", "nose", false, {0, -3.5f, 10.6f}, {1.2f, 1.0f, 1.5f}, 0.22f},
    {"nose_base", "nose", false, {0, -4.6f, 9.4f}, {0.8f, 0.7f, 1.3f}, 0.18f},
    {"nose_wing", "nose", true, {1.5f, -4.0f, 9.0f}, {0.9f, 0.9f, 1.3f}, 0.2f},
    {"nose_flank", "nose", true, {0.9f, -2.2f, 8.7f}, {0.9f, 1.2f, 1.5f}, 0.16f},
    {"philtrum", "mouth", false, {0, -5.6f, 9.2f}, {0.8f, 0.8f, 1.4f}, 0.2f, "xyz", On::upper},
    {"lip_ring_above", "mouth", true, {1.5f, -5.7f, 8.8f}, {1.0f, 0.8f, 1.5f}, 0.2f, "xyz", On::upper},
    {"lip_ring_corner", "mouth", true, {3.1f, -7.1f, 7.8f}, {1.0f, 1.0f, 1.6f}, 0.28f},
    {"lip_ring_below", "mouth", true, {1.6f, -8.7f, 8.4f}, {1.1f, 0.9f, 1.5f}, 0.22f, "xyz", On::lower},
    {"lip_ring_chin", "mouth", false, {0, -8.8f, 8.6f}, {1.1f, 0.8f, 1.5f}, 0.22f, "xyz", On::lower},
    {"chin", "jaw", false, {0, -10.1f, 8.0f}, {1.8f, 1.5f, 2.4f}, 0.32f},
    {"chin_flank", "jaw", true, {2.1f, -9.9f, 7.0f}, {1.6f, 1.5f, 2.4f}, 0.3f},
    {"jaw_line_1", "jaw", true, {4.0f, -9.4f, 4.9f}, {1.8f, 1.7f, 2.6f}, 0.3f},
    {"jaw_line_2", "jaw", true, {5.6f, -8.0f, 2.2f}, {1.8f, 1.9f, 2.6f}, 0.3f},
    {"jaw_corner", "jaw", true, {6.3f, -5.4f, 0.4f}, {1.5f, 2.0f, 2.4f}, 0.25f, "xz"},
    {"under_chin", "neck", false, {0, -11.4f, 5.2f}, {2.0f, 1.3f, 2.2f}, 0.3f, "yz"},
    {"throat", "neck", false, {0, -13.6f, 1.7f}, {1.6f, 1.7f, 2.2f}, 0.3f},
    {"neck_front", "neck", true, {2.2f, -13.8f, 1.0f}, {1.5f, 2.0f, 2.2f}, 0.3f},
    {"neck_side", "neck", true, {4.0f, -12.6f, -1.6f}, {1.9f, 2.4f, 3.0f}, 0.3f, "xz"},
    {"nape", "neck", true, {2.6f, -9.5f, -6.0f}, {2.6f, 3.2f, 3.0f}, 0.3f, "xz"},
    {"ear_top", "cheeks", true, {8.3f, 1.2f, -1.6f}, {1.8f, 1.8f, 2.2f}, 0.25f},
    {"ear_lobe", "cheeks", true, {8.0f, -3.6f, -0.8f}, {1.5f, 1.4f, 1.8f}, 0.22f},
};

Vec3 along(char axis, float reach) {
  return {axis == 'x' ? reach : 0, axis == 'y' ? reach : 0, axis == 'z' ? reach : 0};
}

void add_points(const Canvas& canvas, Controls& controls, std::vector<Term>& terms) {
  for (const TweakPoint& p : kPoints)
    for (int side = 0; side < (p.sided ? 2 : 1); ++side)
      for (const char* axis = p.axes; *axis; ++axis) {
        // Sided points mirror their x as well: positive is outwards on both sides.
        Stroke stroke{p.centre, p.radius, along(*axis, p.reach), p.on};
        if (side == 1) stroke = mirrored(stroke);
        const char* suffix = !p.sided ? "" : side == 0 ? "_L" : "_R";
        const int control = controls.add(std::string(p.name) + "_" + *axis + suffix, p.group, true);
        terms.push_back({Law::linear, {{{control}}}, 1, paint(canvas, {stroke})});
      }
}

// Eleven segments along each lip.
void add_lip_segments(const Canvas& canvas, Controls& controls, std::vector<Term>& terms) {
  for (const On lip : {On::upper, On::lower})
    for (int i = 0; i < 11; ++i)
      for (const char axis : {'x', 'y', 'z'}) {
        const float across = float(i - 5) / 5;
        const float height = (lip == On::upper ? 0.3f : -0.35f) * (1 - across * across);
        const Vec3 centre{kMouthHalfWidth * across, kMouthY + height, 9.4f - 1.4f * across * across};
        const Stroke stroke{centre, {0.75f, 1.0f, 1.5f}, along(axis, axis == 'x' ? 0.15f : 0.28f), lip};
        const std::string name = std::string("lip_") + (lip == On::upper ? "upper_" : "lower_") + segment_name(i, 11);
        const int control = controls.add(name + "_" + axis, "mouth", true);
        terms.push_back({Law::linear, {{{control}}}, 1, paint(canvas, {stroke})});
      }
}

}  // namespace

void add_tweakers(const Canvas& canvas, Controls& controls, std::vector<Term>& terms) {
  add_points(canvas, controls, terms);
  add_lip_segments(canvas, controls, terms);
}

}  // namespace sample_face
