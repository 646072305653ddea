#include "production/sliding_bones.h"

#include <string>

#include "production/lip_bones.h"

namespace rigs::production {
namespace {

float ellipsoid(Vec p) {
  const Vec q = p - head_centre;
  return length({q.x / head_radii.x, q.y / head_radii.y, q.z / head_radii.z});
}

Vec mirrored(Vec v, int side) {
  return {v.x * static_cast<float>(side), v.y, v.z};
}

}  // namespace

SlidingBones::SlidingBones(ControlList& controls, std::vector<FaceBone>& bones, std::size_t lips) {
  for (const int side : {1, -1}) add_brows(controls, bones, side);
  for (const int side : {1, -1}) add_cheeks(controls, bones, side, lips);
  add_middle(controls, bones, lips);
}

SlidingBones::Bone& SlidingBones::add(ControlList& controls, std::vector<FaceBone>& bones, std::string_view name,
                                      std::string_view group, Vec head, int side, float reach, float range) {
  Bone& bone = bones_.emplace_back();
  bone.bone = bones.size();
  bone.head = head;
  bone.side = side;
  bone.channels = controls.add_channels(std::string(name), std::string(group), "xyz", range);
  bone.limit = 1.2f * range;
  bones.push_back({head, reach, skin_parts & ~part_bit(Part::upper_lid) & ~part_bit(Part::lower_lid)});
  return bone;
}

void SlidingBones::add_brows(ControlList& controls, std::vector<FaceBone>& bones, int side) {
  const std::string name = side_name(side);
  const int raise = controls.add("brow_raise" + name, "brows", -1, 1),
            outer = controls.add("brow_outer" + name, "brows", -1, 1),
            squeeze = controls.add("brow_squeeze" + name, "brows", 0, 1);
  const std::size_t first = bones.size();
  for (int i = 0; i < 5; ++i) {
    const float t = static_cast<float>(i) / 4;
    const Vec head = skin_at((0.9f + 3.9f * t) * static_cast<float>(side), 3.1f + 0.6f * std::sin(2.4f * t));
    Bone& bone = add(controls, bones, "brow" + std::to_string(i + 1) + name, "brows", head, side, 1.7f, 1.0f);
    bone.drivers = {{raise, {0, 0.8f * (1 - 0.4f * t), 0}},
                    {outer, {0, 0.8f * t * t, 0}},
                    {squeeze, mirrored({-0.7f * (1 - t), -0.35f * (1 - t), 0.15f}, side)}};
    if (i > 0) bone.follows = {{first + static_cast<std::size_t>(i) - 1, 0.3f}};
    if (i > 0) bone.target = static_cast<int>(first) + i - 1;
  }
  brows_[side < 0] = first + 2;
  for (int i = 0; i < 2; ++i) {
    const Vec head = skin_at((1.4f + 2.4f * static_cast<float>(i)) * static_cast<float>(side), 5.6f);
    Bone& bone = add(controls, bones, "forehead" + std::to_string(i + 1) + name, "brows", head, side, 2.6f, 0.8f);
    bone.follows = {{first + 1 + 2 * static_cast<std::size_t>(i), 0.45f}};
  }
}

void SlidingBones::add_cheeks(ControlList& controls, std::vector<FaceBone>& bones, int side, std::size_t lips) {
  const std::string name = side_name(side);
  const int raise = controls.add("cheek_raise" + name, "cheeks", 0, 1),
            puff = controls.add("cheek_puff" + name, "cheeks", -1, 1),
            sneer = controls.add("sneer" + name, "nose", 0, 1);
  const std::size_t corner = lips + (side > 0 ? LipBones::left_corner : LipBones::right_corner),
                    upper = lips + LipBones::upper + (side > 0 ? 5 : 1);
  struct Place {
    const char* name;
    float x, y, reach, jaw, corner, upper, raise, puff, sneer;
  };
  constexpr Place places[] = {
      {"cheek1", 2.2f, -0.9f, 1.8f, 0.02f, 0.15f, 0.15f, 0.5f, 0.2f, 0.3f},
      {"cheek2", 4.0f, -0.6f, 2.0f, 0.02f, 0.2f, 0.05f, 0.6f, 0.2f, 0.1f},
      {"cheek3", 5.6f, -1.6f, 2.2f, 0.1f, 0.15f, 0, 0.3f, 0.4f, 0},
      {"cheek4", 4.6f, -3.4f, 2.2f, 0.3f, 0.4f, 0.05f, 0.2f, 1, 0},
      {"cheek5", 5.2f, -5.6f, 2.2f, 0.6f, 0.3f, 0, 0, 0.8f, 0},
      {"nasolabial1", 1.7f, -2.4f, 1.2f, 0.02f, 0.2f, 0.35f, 0.2f, 0.1f, 0.6f},
      {"nasolabial2", 2.5f, -3.4f, 1.3f, 0.1f, 0.45f, 0.25f, 0.15f, 0.3f, 0.3f},
      {"nasolabial3", 3.5f, -4.6f, 1.4f, 0.35f, 0.7f, 0, 0.05f, 0.5f, 0},
      {"nasolabial4", 3.3f, -6.6f, 1.5f, 0.7f, 0.5f, 0, 0, 0.4f, 0},
      {"jawline", 4.6f, -8.2f, 2.4f, 0.85f, 0.05f, 0, 0, 0.3f, 0},
      {"nostril", 1.1f, -2.5f, 0.8f, 0, 0, 0.15f, 0, 0, 0.7f},
  };
  for (const Place& place : places) {
    const bool nose = std::string(place.name) == "nostril";
    const Vec head = skin_at(place.x * static_cast<float>(side), place.y);
    Bone& bone =
        add(controls, bones, place.name + name, nose ? "nose" : "cheeks", head, side, place.reach, nose ? 0.5f : 0.9f);
    bone.jaw = place.jaw;
    bone.follows = {{corner, place.corner}, {upper, place.upper}};
    bone.drivers = {{raise, Vec{0, 0.8f, 0.15f} * place.raise},
                    {puff, mirrored(Vec{0.5f, 0, 0.9f} * place.puff, side)},
                    {sneer, mirrored(Vec{-0.1f, 0.7f, 0.1f} * place.sneer, side)}};
    if (place.corner >= 0.3f) bone.target = static_cast<int>(corner);
  }
}

void SlidingBones::add_middle(ControlList& controls, std::vector<FaceBone>& bones, std::size_t lips) {
  Bone& tip = add(controls, bones, "nose_tip", "nose", skin_at(0, -2.2f), 0, 1.2f, 0.6f);
  tip.follows = {{lips + LipBones::upper + 3, 0.2f}};
  add(controls, bones, "nose_bridge", "nose", skin_at(0, 0.6f), 0, 1.2f, 0.4f).follows = {{tip.bone, 0.2f}};
  Bone& glabella = add(controls, bones, "glabella", "brows", skin_at(0, 3.0f), 0, 1.3f, 0.6f);
  glabella.follows = {{brows_[0] - 2, 0.35f}, {brows_[1] - 2, 0.35f}};
  Bone& chin = add(controls, bones, "chin", "jaw", skin_at(0, -8.3f), 0, 2.2f, 0.8f);
  chin.jaw = 1;
  chin.follows = {{lips + LipBones::lower + 3, 0.1f}};
  Bone& throat = add(controls, bones, "throat", "neck", skin_at(0, -11.5f), 0, 2.2f, 0.9f);
  throat.jaw = 0.15f;
}

void SlidingBones::pose(const JawBones& jaw, const float* c, std::vector<Motion>& motions) const {
  for (const Bone& bone : bones_) {
    Vec moved = soft_limit(translation(bone.channels, c, bone.side), bone.limit);
    for (const Driver& driver : bone.drivers) moved += driver.offset * c[driver.control];
    const Motion carrier = jaw.jaw(c, bone.jaw);
    Vec followed;
    for (const auto& [other, share] : bone.follows)
      followed += (motions[other].to - carrier(motions[other].from)) * share;
    const Matrix& frame = bone.follows.empty() ? carrier.matrix : motions[bone.follows[0].first].matrix;
    Vec head = carrier(bone.head) + soft_limit(frame * moved + followed, 1.5f * bone.limit);
    // It slides: three quarters of what would lift it off the skull or press it in are taken back.
    const float out = 0.08f * moved.z;
    const float wanted = ellipsoid(carrier(bone.head)) + out, is = ellipsoid(head);
    head = head_centre + (head - head_centre) * (1 + 0.75f * (wanted / is - 1));
    Matrix matrix = carrier.matrix;
    if (bone.target >= 0) {
      const Motion& target = motions[static_cast<std::size_t>(bone.target)];
      const Vec rest = target.from - bone.head, now = target.to - head;
      const float stretch = 0.5f + soft_limit(length(now) / length(rest) - 0.5f, -0.2f, 1.3f);
      matrix = turn_between(matrix * rest, now) * matrix;
      for (Vec& row : matrix.rows) row = row * (0.4f + 0.6f * stretch);
    }
    motions[bone.bone] = {matrix, bone.head, head};
  }
}

float SlidingBones::brow_height(int side, const std::vector<Motion>& motions) const {
  const Motion& brow = motions[brows_[side < 0]];
  return brow.to.y - brow.from.y;
}

}  // namespace rigs::production
