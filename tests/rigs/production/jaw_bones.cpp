#include "production/jaw_bones.h"

namespace rigs::production {
namespace {

constexpr Vec hinge{0, -1.6f, -0.5f};

}  // namespace

JawBones::JawBones(ControlList& controls, std::vector<FaceBone>& bones)
    : open_(controls.add("jaw.rx", "jaw", -5, 20)),
      swing_(controls.add("jaw.ry", "jaw", -16, 16)),
      twist_(controls.add("jaw.rz", "jaw", -10, 10)),
      side_(controls.add("jaw.tx", "jaw", -0.8f, 0.8f)),
      forward_(controls.add("jaw.tz", "jaw", -0.6f, 1.0f)) {
  const auto rotation = [&](const std::string& name, const std::string& group, const char* axes, float reach) {
    std::vector<int> channels;
    for (const char* axis = axes; *axis; ++axis)
      channels.push_back(controls.add(name + ".r" + *axis, group, -reach, reach));
    return channels;
  };
  for (int i = 0; i < 4; ++i) {
    const std::string name = "tongue" + std::to_string(i + 1);
    const auto translation = i == 0 ? controls.add_channels("tongue", "tongue", "xyz", 1.0f) : std::vector<int>{};
    tongue_.push_back({{0, -5.6f, 2.6f + 1.3f * static_cast<float>(i)},
                       rotation(name, "tongue", "xyz", 30),
                       translation,
                       -32,
                       32,
                       bones.size()});
    bones.push_back({tongue_.back().head + Vec{0, 0, 0.6f}, 1.6f, part_bit(Part::tongue)});
  }
  for (int i = 0; i < 3; ++i) {
    const float down = static_cast<float>(i);
    neck_.push_back({{0, -8.5f - 2.0f * down, -1.5f},
                     rotation("neck" + std::to_string(i + 1), "neck", "xyz", 10),
                     {},
                     -16,
                     16,
                     bones.size()});
    bones.push_back({neck_.back().head + Vec{0, -1.5f, 4.0f}, 4.5f, part_bit(Part::skin)});
  }
}

Motion JawBones::jaw(const float* c, float fraction) const {
  const float open = soft_limit(c[open_], -8, 30);
  const float freedom = 0.4f + 0.6f * smoothstep(-2, 12, open);  // closed teeth hold the jaw
  const float swing = soft_limit(c[swing_] * freedom, -18, 18), twist = soft_limit(c[twist_], -11, 11);
  const Matrix matrix = turn_xyz(radians(open * fraction), radians(swing * fraction), radians(twist * fraction));
  const float slide = 0.03f * soft_ramp(open, 6);  // the hinge glides forward as it opens
  const Vec shift{soft_limit(c[side_], -1.0f, 1.0f) * freedom, -0.4f * slide,
                  soft_limit(c[forward_], -0.8f, 1.2f) + slide};
  return {matrix, hinge, hinge + shift * fraction};
}

void JawBones::pose_chain(const std::vector<Link>& chain, Motion parent, const float* c,
                          std::vector<Motion>& motions) const {
  for (const Link& link : chain) {
    float angles[3] = {};
    for (std::size_t i = 0; i < link.rotation.size(); ++i)
      angles[i] = radians(soft_limit(c[link.rotation[i]], link.low, link.high));
    const Vec shift = link.translation.empty() ? Vec{} : translation(link.translation, c, 1);
    parent = parent * Motion{turn_xyz(angles[0], angles[1], angles[2]), link.head, link.head + shift};
    motions[link.bone] = parent;
  }
}

void JawBones::pose(const float* c, std::vector<Motion>& motions) const {
  pose_chain(tongue_, jaw(c, 0.9f), c, motions);
  pose_chain(neck_, {}, c, motions);
}

}  // namespace rigs::production
