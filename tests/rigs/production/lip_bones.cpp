#include "production/lip_bones.h"

namespace rigs::production {
namespace {

// Pushes a point out of the teeth, an upright half cylinder.
Vec outside_teeth(Vec p) {
  const float x = p.x / teeth_half_width, z = (p.z - teeth_centre_z) / teeth_depth;
  const float far = std::max(0.2f, std::hypot(x, z)), push = soft_ramp(1.02f - far, 0.12f);
  return {p.x * (1 + push / far), p.y, teeth_centre_z + (p.z - teeth_centre_z) * (1 + push / far)};
}

}  // namespace

LipBones::LipBones(ControlList& controls, std::vector<FaceBone>& bones) : first_(bones.size()) {
  const auto sided = [&](const std::string& name) {
    return Sided{controls.add(name + "_L", "mouth", 0, 1), controls.add(name + "_R", "mouth", 0, 1)};
  };
  mouth_ = controls.add_channels("mouth", "mouth", "xyz", 1.2f);
  turn_ = controls.add("mouth.rz", "mouth", -25, 25);
  pucker_ = controls.add("pucker", "mouth", 0, 1);
  funnel_ = controls.add("funnel", "mouth", 0, 1);
  press_ = controls.add("press", "mouth", 0, 1);
  upper_roll_ = controls.add("upper_lip_roll", "mouth", -1, 1);
  lower_roll_ = controls.add("lower_lip_roll", "mouth", -1, 1);
  smile_ = sided("smile");
  frown_ = sided("frown");
  stretch_ = sided("stretch");
  upper_up_ = sided("upper_lip_up");
  lower_down_ = sided("lower_lip_down");
  zip_ = sided("zip");
  add_lips(controls, bones);
}

void LipBones::add_lips(ControlList& controls, std::vector<FaceBone>& bones) {
  for (int i = 0; i < count; ++i) {
    Lip& lip = lips_[static_cast<std::size_t>(i)];
    const bool corner = i >= left_corner;
    const int place = corner ? (i == left_corner ? 4 : -4) : i % 7 - 3;
    lip.row = corner ? 0 : i < lower ? 1 : -1;
    lip.side = place > 0 ? 1 : place < 0 ? -1 : 0;
    const float t = static_cast<float>(std::abs(place)) / 4;
    const float x = mouth_half_width * std::sin(1.5707963f * t) * static_cast<float>(lip.side);
    lip.head = skin_at(x, mouth_centre.y + 0.4f * std::cos(1.5707963f * t) * static_cast<float>(lip.row));
    lip.jaw = lip.row > 0 ? 0.04f + 0.3f * t * t : lip.row < 0 ? 1 - 0.25f * t * t : 0.5f;
    const int start = lip.row < 0 ? lower : upper;
    const auto neighbour = [&](int at) {
      return at > 3 ? int{left_corner} : at < -3 ? int{right_corner} : start + at + 3;
    };
    lip.inward = corner ? (place > 0 ? upper + 6 : upper + 0) : neighbour(place - (lip.side ? lip.side : 1));
    lip.outward = corner ? (place > 0 ? lower + 6 : lower + 0) : neighbour(place + (lip.side ? lip.side : 1));
    const std::string row = corner ? "lip_corner" : lip.row > 0 ? "upper_lip" : "lower_lip";
    const std::string number = corner || place == 0 ? "" : std::to_string(std::abs(place));
    lip.channels = controls.add_channels(row + number + (lip.side == 0 ? "_mid" : side_name(lip.side)),
                                         lip.row > 0   ? "upper_lip"
                                         : lip.row < 0 ? "lower_lip"
                                                       : "mouth",
                                         "xyzr", 1.0f);
    bones.push_back({lip.head, 1.3f, lip.row > 0 ? upper_parts : lip.row < 0 ? lower_parts : skin_parts});
  }
}

float LipBones::weighted(const Sided& control, const Lip& lip, const float* c) {
  const float left = smoothstep(-0.8f, 0.8f, lip.head.x), out = std::abs(lip.head.x) / mouth_half_width;
  const float fall = lip.row == 0 ? 1 : 0.25f + 0.65f * out * out;
  return fall * (c[control.left] * left + c[control.right] * (1 - left));
}

// What the channels of the whole mouth move a bone by.
Vec LipBones::moved_by_mouth(const Lip& lip, const float* c) const {
  const float row = static_cast<float>(lip.row), side = lip.head.x > 0 ? 1.0f : lip.head.x < 0 ? -1.0f : 0.0f;
  const float pucker = c[pucker_], funnel = c[funnel_];
  Vec p = lip.head - mouth_centre;
  p.x *= (1 - 0.42f * pucker) * (1 - 0.28f * funnel);
  p.y += row * (0.5f * funnel * (1 - 0.5f * pucker) - 0.22f * c[press_] - 0.1f * pucker);
  p.z += 1.0f * pucker + 0.6f * funnel * (1 - 0.4f * pucker) - 0.25f * c[press_];
  const float smile = weighted(smile_, lip, c), frown = weighted(frown_, lip, c), wide = weighted(stretch_, lip, c);
  const float room = 1 - 0.35f * pucker;  // a puckered mouth smiles less
  p += Vec{0.9f * side * smile, 0.85f * smile, -0.7f * smile} * room;
  p += Vec{0.25f * side * frown, -0.8f * frown, -0.2f * frown};
  p += Vec{0.9f * side * wide, -0.15f * wide, -0.6f * wide} * room;
  if (lip.row > 0)
    p.y += 0.55f * (c[upper_up_.left] * smoothstep(-1.2f, 1.2f, lip.head.x) +
                    c[upper_up_.right] * smoothstep(-1.2f, 1.2f, -lip.head.x));
  if (lip.row < 0)
    p.y -= 0.6f * (c[lower_down_.left] * smoothstep(-1.2f, 1.2f, lip.head.x) +
                   c[lower_down_.right] * smoothstep(-1.2f, 1.2f, -lip.head.x));
  p = turn({0, 0, 1}, radians(soft_limit(c[turn_], -28, 28))) * p;
  return mouth_centre + p + soft_limit(translation(mouth_, c, 1), 1.6f);
}

LipBones::Shape LipBones::shape(const Lip& lip, const float* c) const {
  const float row = static_cast<float>(lip.row);
  const float in = lip.row > 0 ? c[upper_roll_] : lip.row < 0 ? c[lower_roll_] : 0;
  const float own = soft_limit(c[lip.channels[3]], -46, 46);
  const float roll = row * (0.7f * in - 0.5f * c[funnel_]) + radians(own);
  const Vec rolled{0, -0.22f * row * in, -0.3f * in * in};
  const Vec moved = moved_by_mouth(lip, c) - lip.head +
                    turn({1, 0, 0}, -1.5f * roll) * translation(lip.channels, c, lip.side) + rolled;
  return {outside_teeth(lip.head + soft_limit(moved, 2.2f)), roll};
}

// From either corner inwards, the lips meet between them.
void LipBones::zip(const float* c, std::array<Vec, count>& heads) const {
  for (int i = 0; i < 7; ++i) {
    const float from_left = static_cast<float>(6 - i) / 6, from_right = static_cast<float>(i) / 6;
    const float left = smoothstep(0.8f * from_left - 0.02f, 0.8f * from_left + 0.3f, 1.1f * c[zip_.left]);
    const float right = smoothstep(0.8f * from_right - 0.02f, 0.8f * from_right + 0.3f, 1.1f * c[zip_.right]);
    const float closed = 1 - (1 - left) * (1 - right);
    Vec &up = heads[upper + i], &down = heads[lower + i];
    const Vec apart = (lips_[upper + i].head - lips_[lower + i].head) * 0.25f, meet = mix(up, down, 0.5f);
    up = mix(up, meet + apart, 0.9f * closed);
    down = mix(down, meet - apart, 0.9f * closed);
  }
}

// Keeps an upper bone above the lower one.
void LipBones::part(const JawBones& jaw, const float* c, std::array<Vec, count>& heads) const {
  const Vec up = jaw.jaw(c, 0.5f).matrix * Vec{0, 1, 0};
  for (int i = 0; i < 7; ++i) {
    const float gap = dot(heads[upper + i] - heads[lower + i], up);
    const float least = 0.6f * (lips_[upper + i].head.y - lips_[lower + i].head.y);
    const Vec push = up * (0.5f * soft_ramp(least - gap, 0.2f));
    heads[upper + i] += push;
    heads[lower + i] += push * -1;
  }
}

void LipBones::pose(const JawBones& jaw, const float* c, std::vector<Motion>& motions) const {
  std::array<Vec, count> heads;
  std::array<Matrix, count> carriers;
  std::array<float, count> rolls;
  for (std::size_t i = 0; i < count; ++i) {
    const Motion carrier = jaw.jaw(c, lips_[i].jaw);
    const Shape formed = shape(lips_[i], c);
    heads[i] = carrier(formed.head);
    carriers[i] = carrier.matrix;
    rolls[i] = formed.roll;
  }
  zip(c, heads);
  part(jaw, c, heads);
  for (std::size_t i = 0; i < count; ++i) {
    const Lip& lip = lips_[i];
    const auto in = static_cast<std::size_t>(lip.inward), out = static_cast<std::size_t>(lip.outward);
    const Vec along = lips_[out].head - lips_[in].head, now = heads[out] - heads[in];
    const Vec axis = along * (1 / length(along));
    const float stretch = 0.6f + soft_limit(length(now) / length(along) - 0.6f, -0.2f, 1.2f);
    Matrix form = turn(axis, rolls[i] * (axis.x < 0 ? -1.0f : 1.0f));
    const Vec longer = axis * (stretch - 1);
    form =
        form * Matrix{{Vec{1, 0, 0} + longer * axis.x, Vec{0, 1, 0} + longer * axis.y, Vec{0, 0, 1} + longer * axis.z}};
    motions[first_ + i] = {turn_between(carriers[i] * along, now) * carriers[i] * form, lip.head, heads[i]};
  }
}

}  // namespace rigs::production
