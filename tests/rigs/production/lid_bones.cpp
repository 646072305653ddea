#include "production/lid_bones.h"

namespace rigs::production {
namespace {

constexpr float lid_range = 0.5f;

}  // namespace

LidBones::LidBones(ControlList& controls, std::vector<FaceBone>& bones)
    : look_x_(controls.add("look.tx", "eyes", -1, 1)), look_y_(controls.add("look.ty", "eyes", -1, 1)) {
  for (const int side : {1, -1}) {
    Eye& eye = eyes_[side < 0];
    eye.side = side;
    add_eye(controls, bones, eye);
  }
}

void LidBones::add_eye(ControlList& controls, std::vector<FaceBone>& bones, Eye& eye) {
  const std::string name = side_name(eye.side);
  eye.look = {controls.add("eye" + name + ".rx", "eyes", -30, 30), controls.add("eye" + name + ".ry", "eyes", -40, 40)};
  eye.blink = controls.add("blink" + name, "lids", 0, 1);
  eye.wide = controls.add("wide" + name, "lids", 0, 1);
  eye.squint = controls.add("squint" + name, "lids", 0, 1);
  eye.twist = controls.add("lid_twist" + name, "lids", -1, 1);
  for (const bool up : {true, false})
    for (std::size_t i = 0; i < lid_count; ++i) {
      const float t = -1 + 0.5f * static_cast<float>(i), arc = std::sqrt(1.1f - t * t);
      Lid& lid = (up ? eye.upper : eye.lower)[i];
      const Vec centre = eye_centre(eye.side);
      lid.head = skin_at(centre.x + 1.5f * t * static_cast<float>(eye.side), centre.y + (up ? 0.6f : -0.6f) * arc);
      lid.channels = controls.add_channels((up ? "upper_lid" : "lower_lid") + std::to_string(i + 1) + name, "lids",
                                           "yz", lid_range);
      lid.bone = bones.size();
      bones.push_back({lid.head, 0.9f, part_bit(Part::skin) | part_bit(up ? Part::upper_lid : Part::lower_lid)});
    }
}

void LidBones::pose(const float* c, const SlidingBones& skin, std::vector<Motion>& motions) const {
  for (const Eye& eye : eyes_) {
    const Vec centre = eye_centre(eye.side);
    const float pitch = soft_limit(c[eye.look[0]] - 22 * c[look_y_], -36, 36),
                yaw = soft_limit(c[eye.look[1]] + 28 * c[look_x_], -46, 46);
    const float blink = soft_limit(c[eye.blink] - 0.4f * c[eye.wide], -0.4f, 1.15f), squint = c[eye.squint];
    const float pressed = 0.25f * soft_ramp(-skin.brow_height(eye.side, motions) - 0.1f, 0.15f);
    for (std::size_t i = 0; i < lid_count; ++i) {
      const Lid &up = eye.upper[i], &low = eye.lower[i];
      const float t = -1 + 0.5f * static_cast<float>(i), arc = 1 - 0.55f * t * t;
      const Vec a = up.head - centre, b = low.head - centre;
      const float rest_up = std::atan2(a.y, a.z), rest_low = std::atan2(b.y, b.z);
      float low_angle = rest_low + 0.45f * c[low.channels[0]] + arc * (0.12f * squint - 0.1f * c[eye.wide]) +
                        radians(-0.3f * pitch) * arc + 0.05f * c[eye.twist] * t + 0.05f * blink;
      float up_angle = rest_up + 0.45f * c[up.channels[0]] + arc * (0.16f * c[eye.wide] - 0.1f * squint - pressed) +
                       radians(-0.55f * pitch) * arc * (1 - 0.7f * smoothstep(0, 1, blink)) + 0.12f * c[eye.twist] * t;
      up_angle = std::lerp(up_angle, low_angle + 0.03f, smoothstep(-0.15f, 1.05f, blink));
      const float overlap = soft_ramp(low_angle - up_angle, 0.06f);
      up_angle += 0.7f * overlap;
      low_angle -= 0.3f * overlap;
      // The cornea lifts the lid it is under.
      const float away = 28 * t * static_cast<float>(eye.side) - yaw;
      const float bulge = 0.12f * std::exp(-away * away / 500);
      for (const bool upper : {true, false}) {
        const Lid& lid = upper ? up : low;
        const float angle = upper ? up_angle - rest_up : low_angle - rest_low;
        const Matrix matrix = turn({1, 0, 0}, -angle);
        const float lift = 1 + (0.3f * c[lid.channels[1]] + bulge) / length(lid.head - centre);
        const Vec slide{0.006f * yaw, 0, 0};
        motions[lid.bone] = {matrix, lid.head, centre + matrix * (lid.head - centre) * lift + slide};
      }
    }
  }
}

}  // namespace rigs::production
