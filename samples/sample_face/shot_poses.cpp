#include "shot_poses.h"

#include <stdexcept>

namespace sample_face {
namespace {

struct Setting {
  const char* control;  // a name ending in "_*" sets both sides
  float value;
};

struct KeyPose {
  const char* name;
  std::vector<Setting> settings;
};

const std::vector<KeyPose>& key_poses() {
  static const std::vector<KeyPose> poses = {
      {"rest", {}},
      {"smile",
       {{"smile_*", 0.9f},
        {"cheek_raise_*", 0.5f},
        {"squint_*", 0.35f},
        {"dimple_*", 0.3f},
        {"nasolabial_*", 0.4f},
        {"lips_stick", 0.4f}}},
      {"laugh",
       {{"smile_*", 1},
        {"cheek_raise_*", 0.8f},
        {"jaw_open", 0.5f},
        {"squint_*", 0.7f},
        {"upper_lip_raise_*", 0.5f},
        {"blink_*", 0.35f},
        {"brow_mid_*", 0.3f},
        {"nose_wrinkle_*", 0.25f},
        {"lip_roll_upper", -0.3f}}},
      {"blink", {{"blink_*", 1}, {"brow_mid_*", -0.1f}, {"cheek_raise_*", 0.1f}}},
      {"look_left", {{"look_x", 0.8f}, {"brow_outer_L", 0.25f}, {"mouth_swing", 0.15f}}},
      {"look_right", {{"look_x", -0.8f}, {"brow_outer_R", 0.25f}, {"mouth_swing", -0.15f}}},
      {"look_up", {{"look_y", 0.7f}, {"brow_mid_*", 0.5f}, {"brow_inner_*", 0.4f}, {"forehead_fold_*", 0.5f}}},
      {"look_down", {{"look_y", -0.8f}, {"brow_mid_*", -0.2f}, {"blink_*", 0.2f}}},
      {"anger",
       {{"brow_inner_*", -0.9f},
        {"brow_mid_*", -0.6f},
        {"brow_squeeze_*", 0.9f},
        {"squint_*", 0.5f},
        {"nose_wrinkle_*", 0.6f},
        {"lip_press_*", 0.6f},
        {"lip_tighten_*", 0.6f},
        {"jaw_clench_*", 0.8f},
        {"frown_*", 0.4f},
        {"nostril_*", 0.6f},
        {"chin_raise", 0.4f},
        {"upper_lid_*", 0.3f}}},
      {"shout",
       {{"brow_inner_*", -0.7f},
        {"brow_squeeze_*", 0.8f},
        {"jaw_open", 0.85f},
        {"upper_lip_raise_*", 0.8f},
        {"lower_lip_down_*", 0.8f},
        {"nose_wrinkle_*", 0.8f},
        {"stretch_*", 0.5f},
        {"neck_tense_*", 0.8f},
        {"neck_turn_*", 0.5f},
        {"cheek_raise_*", 0.5f},
        {"jaw_forward", 0.3f}}},
      {"surprise",
       {{"brow_inner_*", 0.9f},
        {"brow_mid_*", 0.9f},
        {"brow_outer_*", 0.9f},
        {"forehead_fold_*", 0.7f},
        {"upper_lid_*", 0.8f},
        {"jaw_open", 0.5f},
        {"funnel", 0.35f},
        {"pupil_*", -0.4f},
        {"lips_stick", 0.7f}}},
      {"sad",
       {{"brow_inner_*", 0.8f},
        {"brow_outer_*", -0.4f},
        {"brow_squeeze_*", 0.5f},
        {"frown_*", 0.8f},
        {"chin_raise", 0.6f},
        {"upper_lid_*", -0.35f},
        {"look_y", -0.3f},
        {"lower_lip_push", 0.4f}}},
      {"disgust",
       {{"nose_wrinkle_*", 0.9f},
        {"sneer_*", 0.7f},
        {"upper_lip_raise_*", 0.5f},
        {"nasolabial_*", 0.7f},
        {"squint_*", 0.6f},
        {"brow_mid_*", -0.6f},
        {"mouth_swing", 0.4f},
        {"lower_lip_push", 0.5f},
        {"tongue_out", 0.3f},
        {"jaw_open", 0.2f}}},
      {"whisper",
       {{"funnel", 0.3f},
        {"jaw_open", 0.12f},
        {"brow_inner_*", 0.3f},
        {"look_x", 0.4f},
        {"lip_tighten_*", 0.3f},
        {"squint_*", 0.2f}}},
      {"pucker",
       {{"pucker", 1},
        {"mouth_wide_*", -0.3f},
        {"lip_roll_upper", 0.4f},
        {"lip_roll_lower", 0.4f},
        {"chin_raise", 0.2f},
        {"cheek_puff_*", -0.4f}}},
      {"kiss",
       {{"pucker", 0.8f},
        {"funnel", 0.4f},
        {"blink_*", 0.7f},
        {"lip_curl_upper", 0.4f},
        {"lip_curl_lower", 0.4f},
        {"brow_mid_*", 0.3f}}},
      {"smirk",
       {{"smile_L", 0.8f},
        {"dimple_L", 0.7f},
        {"corner_in_R", 0.4f},
        {"cheek_raise_L", 0.5f},
        {"brow_outer_R", 0.7f},
        {"mouth_swing", 0.3f},
        {"squint_L", 0.4f},
        {"nasolabial_L", 0.5f}}},
      {"AA",
       {{"jaw_open", 0.65f},
        {"mouth_wide_*", 0.1f},
        {"lower_lip_down_*", 0.25f},
        {"lips_stick", 0.3f},
        {"tongue_pitch_2", -0.3f}}},
      {"EE",
       {{"jaw_open", 0.18f},
        {"mouth_wide_*", 0.7f},
        {"stretch_*", 0.3f},
        {"upper_lip_raise_*", 0.4f},
        {"lower_lip_down_*", 0.4f},
        {"tongue_wide", 0.5f},
        {"tongue_pitch_2", 0.4f}}},
      {"OO", {{"jaw_open", 0.25f}, {"pucker", 0.75f}, {"funnel", 0.4f}, {"lip_curl_lower", 0.2f}}},
      {"OH", {{"jaw_open", 0.45f}, {"funnel", 0.8f}, {"mouth_wide_*", -0.4f}, {"lip_roll_lower", 0.3f}}},
      {"MM",
       {{"lip_press_*", 0.8f},
        {"lip_roll_upper", -0.5f},
        {"lip_roll_lower", -0.5f},
        {"lips_together", 0.6f},
        {"jaw_open", 0.1f}}},
      {"FV", {{"lip_bite", 0.8f}, {"upper_lip_raise_*", 0.35f}, {"jaw_open", 0.12f}, {"lip_roll_lower", -0.6f}}},
      {"TH",
       {{"jaw_open", 0.22f},
        {"tongue_out", 0.35f},
        {"tongue_pitch_4", 0.4f},
        {"lower_lip_down_*", 0.4f},
        {"upper_lip_raise_*", 0.2f}}},
      {"LL", {{"jaw_open", 0.3f}, {"tongue_pitch_3", 0.7f}, {"tongue_pitch_4", 0.8f}, {"mouth_wide_*", 0.2f}}},
      {"tongue",
       {{"jaw_open", 0.55f},
        {"tongue_out", 1},
        {"tongue_pitch_3", -0.5f},
        {"tongue_pitch_4", -0.5f},
        {"squint_*", 0.6f},
        {"nose_wrinkle_*", 0.3f},
        {"smile_*", 0.3f}}},
      {"chew_left",
       {{"jaw_side", 0.7f},
        {"jaw_open", 0.2f},
        {"lip_press_*", 0.3f},
        {"cheek_puff_L", 0.6f},
        {"jaw_twist", 0.4f},
        {"lips_together", 0.9f}}},
      {"chew_right",
       {{"jaw_side", -0.7f},
        {"jaw_open", 0.12f},
        {"lip_press_*", 0.4f},
        {"cheek_puff_R", 0.5f},
        {"jaw_twist", -0.4f},
        {"lips_together", 0.9f}}},
      {"puff",
       {{"cheek_puff_*", 1},
        {"lip_press_*", 0.5f},
        {"lip_roll_upper", -0.4f},
        {"lip_roll_lower", -0.4f},
        {"brow_mid_*", 0.4f},
        {"throat_puff", 0.5f}}},
      {"suck",
       {{"cheek_puff_*", -1}, {"pucker", 0.6f}, {"jaw_open", 0.15f}, {"lips_suck", 0.3f}, {"brow_inner_*", 0.4f}}},
      {"wide_open",
       {{"jaw_open", 1},
        {"lips_zip_L", 0.35f},
        {"lips_zip_R", 0.35f},
        {"brow_mid_*", 0.5f},
        {"neck_tense_*", 0.4f},
        {"face_squash", -0.5f}}},
      {"scrunch",
       {{"face_squash", 0.8f},
        {"squint_*", 1},
        {"blink_*", 0.9f},
        {"nose_wrinkle_*", 0.9f},
        {"brow_squeeze_*", 0.9f},
        {"brow_mid_*", -0.7f},
        {"cheek_raise_*", 0.8f},
        {"pucker", 0.4f},
        {"chin_raise", 0.6f}}},
      {"bend_left",
       {{"face_bend", 0.8f}, {"jaw_side", 0.5f}, {"mouth_twist", 0.5f}, {"blink_L", 0.8f}, {"smile_L", 0.5f}}},
      {"bend_right",
       {{"face_bend", -0.8f}, {"jaw_side", -0.5f}, {"mouth_twist", -0.5f}, {"blink_R", 0.8f}, {"smile_R", 0.5f}}},
  };
  return poses;
}

// Every control's value in a pose.
std::vector<float> values_of(const KeyPose& pose, const Controls& controls) {
  std::vector<float> values(controls.list().size(), 0.0f);
  for (const Setting& s : pose.settings) {
    std::string name(s.control);
    if (name.back() != '*') {
      values[controls.index(name)] = s.value;
      continue;
    }
    for (const char side : {'L', 'R'}) {
      name.back() = side;
      values[controls.index(name)] = s.value;
    }
  }
  return values;
}

}  // namespace

std::vector<float> shot_pose(const std::string& name, const Controls& controls) {
  for (const KeyPose& pose : key_poses())
    if (name == pose.name) return values_of(pose, controls);
  throw std::out_of_range("there is no pose '" + name + "'");
}

}  // namespace sample_face
