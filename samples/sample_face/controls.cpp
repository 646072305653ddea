#include "controls.h"

#include <stdexcept>
#include <utility>

namespace sample_face {

int Controls::add(std::string name, std::string group, bool two_sided) {
  const int index = int(list_.size());
  if (!indices_.emplace(name, index).second) throw std::logic_error("control '" + name + "' is there twice");
  list_.push_back({std::move(name), std::move(group), two_sided});
  return index;
}

int Controls::index(const std::string& name) const {
  const auto found = indices_.find(name);
  if (found == indices_.end()) throw std::out_of_range("there is no control '" + name + "'");
  return found->second;
}

std::string segment_name(int segment, int count) {
  const int from_middle = segment - count / 2;
  if (from_middle == 0) return "M";
  return std::string(from_middle > 0 ? "L" : "R").append(std::to_string(std::abs(from_middle)));
}

MotionControls add_motion_controls(Controls& controls) {
  constexpr const char* kSide[2] = {"_L", "_R"};
  constexpr const char* kHalf[2] = {"upper", "lower"};
  MotionControls m{};
  const auto one = [&](const char* group, const std::string& name) { return controls.add(name, group, false); };
  const auto two = [&](const char* group, const std::string& name) { return controls.add(name, group, true); };

  m.jaw_open = one("jaw", "jaw_open");
  m.jaw_side = two("jaw", "jaw_side");
  m.jaw_forward = two("jaw", "jaw_forward");
  m.jaw_twist = two("jaw", "jaw_twist");

  m.look_x = two("eyes", "look_x");
  m.look_y = two("eyes", "look_y");
  for (int s = 0; s < 2; ++s) {
    m.eye_yaw[s] = two("eyes", std::string("eye_yaw") + kSide[s]);
    m.eye_pitch[s] = two("eyes", std::string("eye_pitch") + kSide[s]);
    m.eye_out[s] = one("eyes", std::string("eye_out") + kSide[s]);
    m.pupil[s] = two("eyes", std::string("pupil") + kSide[s]);
    m.blink[s] = one("lids", std::string("blink") + kSide[s]);
    m.upper_lid[s] = two("lids", std::string("upper_lid") + kSide[s]);
    m.lower_lid[s] = two("lids", std::string("lower_lid") + kSide[s]);
    m.lid_tilt[s] = two("lids", std::string("lid_tilt") + kSide[s]);
    for (int half = 0; half < 2; ++half)
      for (int i = 0; i < 5; ++i) {
        const std::string segment = std::string("lid_") + kHalf[half] + "_" + std::to_string(i + 1);
        m.lid_up[s][half][i] = two("lids", segment + "_up" + kSide[s]);
        m.lid_thick[s][half][i] = one("lids", segment + "_full" + kSide[s]);
      }
  }

  for (int half = 0; half < 2; ++half) {
    const std::string lip = std::string("lip_roll_") + kHalf[half];
    m.roll[half] = two("mouth", lip);
    for (int s = 0; s < 2; ++s) m.roll_side[half][s] = two("mouth", lip + kSide[s]);
    m.curl[half] = two("mouth", std::string("lip_curl_") + kHalf[half]);
    for (int i = 0; i < 11; ++i) {
      const std::string segment = std::string("lip_") + kHalf[half] + "_" + segment_name(i, 11);
      m.lip_turn[half][i] = two("mouth", segment + "_turn");
      m.lip_full[half][i] = two("mouth", segment + "_full");
    }
  }
  m.zip[0] = one("mouth", "lips_zip_L");
  m.zip[1] = one("mouth", "lips_zip_R");
  m.stick = one("mouth", "lips_stick");
  m.lips_together = one("mouth", "lips_together");
  m.mouth_swing = two("mouth", "mouth_swing");
  m.mouth_twist = two("mouth", "mouth_twist");

  m.tongue_out = one("tongue", "tongue_out");
  for (int i = 0; i < 4; ++i) {
    m.tongue_pitch[i] = two("tongue", "tongue_pitch_" + std::to_string(i + 1));
    m.tongue_yaw[i] = two("tongue", "tongue_yaw_" + std::to_string(i + 1));
  }
  m.tongue_twist = two("tongue", "tongue_twist");
  m.tongue_wide = two("tongue", "tongue_wide");
  m.tongue_gutter = two("tongue", "tongue_gutter");

  m.squash = two("jaw", "face_squash");
  m.bend = two("neck", "face_bend");
  return m;
}

}  // namespace sample_face
