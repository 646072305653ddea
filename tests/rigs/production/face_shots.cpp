#include <map>

#include "production/draw.h"
#include "production/face_poses.h"

namespace rigs::production {
namespace {

// A control and its value as a share of its range; "*" stands for both sides.
struct Setting {
  const char* control;
  float share;
};
using Settings = std::vector<Setting>;

const std::map<std::string, Settings>& library() {
  static const std::map<std::string, Settings> all = {
      {"rest", {}},
      {"AA",
       {{"jaw.rx", 0.55f},
        {"lower_lip_down*", 0.3f},
        {"upper_lip_up*", 0.2f},
        {"lower_lip_mid.ty", -0.2f},
        {"upper_lip1*.ty", 0.15f},
        {"tongue1.rx", 0.2f},
        {"nasolabial4*.ty", -0.2f},
        {"cheek5*.tx", -0.2f}}},
      {"EE",
       {{"jaw.rx", 0.15f},
        {"stretch*", 0.6f},
        {"smile*", 0.2f},
        {"lower_lip_down*", 0.4f},
        {"lip_corner*.tx", 0.3f},
        {"lower_lip1*.ty", -0.3f},
        {"tongue2.rx", -0.3f},
        {"cheek4*.tx", 0.2f}}},
      {"OO",
       {{"jaw.rx", 0.12f},
        {"pucker", 0.75f},
        {"funnel", 0.3f},
        {"lip_corner*.tx", -0.4f},
        {"upper_lip_mid.tz", 0.3f},
        {"lower_lip_mid.tz", 0.35f},
        {"upper_lip2*.roll", 0.3f},
        {"cheek4*.tx", -0.3f}}},
      {"OH",
       {{"jaw.rx", 0.4f},
        {"funnel", 0.6f},
        {"pucker", 0.3f},
        {"upper_lip1*.ty", 0.25f},
        {"lower_lip2*.ty", -0.25f},
        {"lip_corner*.tz", 0.3f},
        {"tongue1.rx", 0.25f}}},
      {"MM",
       {{"press", 0.7f},
        {"upper_lip_roll", 0.4f},
        {"lower_lip_roll", 0.5f},
        {"jaw.rx", 0.03f},
        {"lip_corner*.ty", 0.1f},
        {"upper_lip2*.ty", -0.15f},
        {"zip*", 0.3f},
        {"chin.ty", 0.3f}}},
      {"FV",
       {{"jaw.rx", 0.1f},
        {"lower_lip_roll", 0.7f},
        {"upper_lip_up*", 0.4f},
        {"lower_lip_mid.tz", -0.3f},
        {"lower_lip1*.ty", 0.3f},
        {"upper_lip_mid.ty", 0.2f},
        {"jaw.tz", -0.3f}}},
      {"TH",
       {{"jaw.rx", 0.2f},
        {"tongue.tz", 0.6f},
        {"tongue2.rx", -0.2f},
        {"tongue4.rx", 0.3f},
        {"lower_lip_down*", 0.3f},
        {"stretch*", 0.2f},
        {"upper_lip1*.tz", 0.2f}}},
      {"smile",
       {{"smile*", 0.85f},
        {"cheek_raise*", 0.6f},
        {"squint*", 0.4f},
        {"cheek2*.ty", 0.3f},
        {"nasolabial2*.tz", 0.3f},
        {"lip_corner*.tx", 0.3f},
        {"upper_lip3*.ty", 0.2f},
        {"lower_lid3*.ty", 0.3f},
        {"brow_outer*", 0.2f},
        {"nostril*.tx", 0.3f}}},
      {"laugh",
       {{"smile*", 0.9f},
        {"jaw.rx", 0.5f},
        {"cheek_raise*", 0.9f},
        {"squint*", 0.8f},
        {"sneer*", 0.3f},
        {"upper_lip_up*", 0.5f},
        {"cheek1*.ty", 0.4f},
        {"lower_lid2*.ty", 0.4f},
        {"neck1.rx", -0.3f},
        {"stretch*", 0.4f},
        {"nasolabial1*.tx", 0.3f},
        {"tongue1.rx", 0.3f},
        {"chin.ty", -0.2f}}},
      {"anger",
       {{"brow_squeeze*", 0.9f},
        {"brow_raise*", -0.7f},
        {"sneer*", 0.5f},
        {"wide*", 0.4f},
        {"press", 0.5f},
        {"brow1*.ty", -0.4f},
        {"brow2*.tx", -0.3f},
        {"jaw.tz", 0.5f},
        {"nostril*.tx", 0.6f},
        {"frown*", 0.4f},
        {"upper_lid2*.ty", -0.3f},
        {"glabella.ty", -0.4f},
        {"forehead1*.ty", -0.3f},
        {"throat.tz", 0.4f}}},
      {"sad",
       {{"brow_squeeze*", 0.5f},
        {"brow1*.ty", 0.7f},
        {"brow2*.ty", 0.4f},
        {"brow_outer*", -0.5f},
        {"frown*", 0.7f},
        {"lower_lip_mid.tz", 0.4f},
        {"chin.ty", 0.5f},
        {"upper_lid4*.ty", -0.4f},
        {"lid_twist*", -0.6f},
        {"lower_lip1*.roll", -0.3f},
        {"cheek4*.ty", -0.3f},
        {"blink*", 0.2f}}},
      {"surprise",
       {{"brow_raise*", 0.95f},
        {"wide*", 0.9f},
        {"jaw.rx", 0.6f},
        {"brow3*.ty", 0.4f},
        {"brow4*.ty", 0.4f},
        {"forehead1*.ty", 0.4f},
        {"forehead2*.ty", 0.3f},
        {"upper_lid3*.ty", 0.3f},
        {"funnel", 0.2f},
        {"lip_corner*.ty", -0.3f},
        {"neck1.rx", 0.2f},
        {"throat.ty", -0.3f}}},
      {"disgust",
       {{"sneer*", 0.95f},
        {"upper_lip_up*", 0.7f},
        {"squint*", 0.6f},
        {"brow_squeeze*", 0.6f},
        {"nasolabial1*.ty", 0.5f},
        {"nostril*.ty", 0.5f},
        {"frown*", 0.3f},
        {"tongue.tz", 0.3f},
        {"lower_lip_roll", -0.5f},
        {"nose_tip.ty", 0.4f},
        {"cheek1*.ty", 0.4f},
        {"jaw.rx", 0.2f}}},
      {"smirk",
       {{"smile_L", 0.9f},
        {"cheek_raise_L", 0.5f},
        {"brow_raise_R", 0.7f},
        {"squint_L", 0.5f},
        {"mouth.tx", 0.5f},
        {"mouth.rz", 0.3f},
        {"lip_corner_L.ty", 0.4f},
        {"press", 0.3f},
        {"brow_outer_R", 0.5f},
        {"nasolabial3_L.tx", 0.4f},
        {"jaw.ry", 0.3f}}},
      {"chew",
       {{"jaw.rx", 0.3f},
        {"jaw.ry", 0.7f},
        {"jaw.tx", 0.5f},
        {"zip*", 0.4f},
        {"cheek_puff_L", 0.6f},
        {"mouth.tx", 0.3f},
        {"tongue1.ry", 0.6f},
        {"tongue3.ry", 0.5f},
        {"press", 0.3f},
        {"jawline_L.tx", 0.4f}}},
      {"puff",
       {{"cheek_puff*", 0.9f},
        {"press", 0.6f},
        {"pucker", 0.3f},
        {"zip*", 0.5f},
        {"cheek4*.tz", 0.3f},
        {"nasolabial3*.tz", 0.4f},
        {"wide*", 0.3f},
        {"brow_raise*", 0.3f}}},
      {"blink", {{"blink*", 1}, {"squint*", 0.2f}, {"brow_raise*", -0.1f}, {"lower_lid3*.ty", 0.2f}}},
      {"look_left", {{"look.tx", 0.8f}, {"neck1.ry", 0.4f}, {"neck2.ry", 0.3f}, {"brow_raise_L", 0.2f}}},
      {"look_up", {{"look.ty", 0.8f}, {"neck1.rx", -0.4f}, {"brow_raise*", 0.5f}, {"wide*", 0.3f}}},
      {"look_down", {{"look.ty", -0.8f}, {"look.tx", -0.4f}, {"neck1.rx", 0.5f}, {"neck2.rx", 0.3f}}},
  };
  return all;
}

// Shots stay well within the ranges.
constexpr float strength = 0.7f;

std::vector<float> pose_of(const std::string& name, const ControlList& controls) {
  std::vector<float> pose(controls.list().size());
  for (const Setting& setting : library().at(name)) {
    const std::string text = setting.control;
    const std::size_t star = text.find('*');
    for (const int side : {1, -1}) {
      std::string control = text;
      if (star != std::string::npos) control.replace(star, 1, side_name(side));
      const auto c = static_cast<std::size_t>(controls.index(control));
      const ControlRange& range = controls.list()[c];
      pose[c] = strength * std::abs(setting.share) * (setting.share < 0 ? range.minimum : range.maximum);
    }
  }
  return pose;
}

// From this second on, the face eases into the pose.
struct Key {
  float time, ease;
  const char* pose;
  float amount;
};
struct ShotPlan {
  const char* name;
  std::size_t frames;
  const char* moods[2];
  std::vector<Key> keys;
};

const std::vector<ShotPlan>& plans() {
  static const std::vector<ShotPlan> all = {
      {"talking",
       300,
       {"smile", "sad"},
       {{0.2f, 0.15f, "MM", 1},        {0.5f, 0.15f, "AA", 1},       {0.9f, 0.15f, "EE", 0.9f},
        {1.2f, 0.12f, "FV", 1},        {1.5f, 0.15f, "OH", 1},       {1.9f, 0.15f, "OO", 1},
        {2.3f, 0.12f, "TH", 1},        {2.6f, 0.15f, "AA", 0.7f},    {3.0f, 0.12f, "MM", 0.9f},
        {3.3f, 0.1f, "blink", 1},      {3.5f, 0.2f, "look_left", 1}, {4.0f, 0.15f, "OO", 0.8f},
        {4.4f, 0.15f, "AA", 1.1f},     {4.8f, 0.15f, "EE", 1},       {5.1f, 0.12f, "TH", 0.8f},
        {5.5f, 0.15f, "OH", 0.9f},     {5.9f, 0.12f, "FV", 0.9f},    {6.3f, 0.3f, "look_up", 0.8f},
        {7.0f, 0.15f, "MM", 1},        {7.3f, 0.15f, "AA", 0.9f},    {7.7f, 0.15f, "OO", 1},
        {8.1f, 0.1f, "blink", 1},      {8.3f, 0.15f, "EE", 0.9f},    {8.7f, 0.2f, "smirk", 0.8f},
        {9.4f, 0.15f, "OH", 1},        {9.8f, 0.12f, "MM", 1},       {10.2f, 0.15f, "AA", 0.8f},
        {10.6f, 0.2f, "look_down", 1}, {11.2f, 0.15f, "FV", 1},      {11.5f, 0.4f, "smile", 0.6f}}},
      {"expressive",
       288,
       {"anger", "surprise"},
       {{0.3f, 0.3f, "smile", 1},
        {1.2f, 0.25f, "laugh", 0.8f},
        {1.9f, 0.2f, "laugh", 0.5f},
        {2.3f, 0.2f, "laugh", 0.8f},
        {3.0f, 0.3f, "disgust", 1},
        {3.9f, 0.3f, "anger", 1},
        {4.6f, 0.2f, "AA", 1},
        {5.0f, 0.3f, "surprise", 0.9f},
        {5.9f, 0.1f, "blink", 1},
        {6.1f, 0.4f, "sad", 1},
        {7.1f, 0.3f, "smirk", 1},
        {8.0f, 0.25f, "chew", 0.8f},
        {8.6f, 0.25f, "puff", 1},
        {9.3f, 0.3f, "surprise", 0.8f},
        {10.0f, 0.3f, "anger", 0.9f},
        {10.8f, 0.3f, "laugh", 0.75f},
        {11.5f, 0.3f, "rest", 1}}},
  };
  return all;
}

// Smooth noise in [-1, 1], through random values once a unit of t.
float noise(std::uint64_t stream, float t) {
  const float cell = std::floor(t);
  const auto at = [&](float i) { return Draw(stream, static_cast<std::uint64_t>(i)).between(-1, 1); };
  return std::lerp(at(cell), at(cell + 1), smoothstep(0, 1, t - cell));
}

// The poses of a plan's keys, then of its moods.
std::vector<std::vector<float>> poses_of(const ShotPlan& plan, const ControlList& controls) {
  std::vector<std::vector<float>> poses;
  for (const Key& key : plan.keys) poses.push_back(pose_of(key.pose, controls));
  for (const char* mood : plan.moods) poses.push_back(pose_of(mood, controls));
  return poses;
}

std::vector<float> frame_of(const ShotPlan& plan, const std::vector<std::vector<float>>& poses, std::uint64_t seed,
                            float time, const ControlList& controls) {
  const std::size_t width = controls.list().size(), keys = plan.keys.size();
  std::vector<float> row(width);
  for (std::size_t k = 0; k < keys; ++k) {
    const Key& key = plan.keys[k];
    for (std::size_t c = 0; c < width; ++c) {
      const float late = 0.08f * Draw(seed, c).unit();  // no face moves all at once
      row[c] =
          std::lerp(row[c], poses[k][c] * key.amount, smoothstep(key.time + late, key.time + late + key.ease, time));
    }
  }
  const float end = static_cast<float>(plan.frames) / static_cast<float>(shot_fps);
  const float fade = smoothstep(0, 0.5f, time) * smoothstep(0, 0.5f, end - time);
  for (std::size_t c = 0; c < width; ++c) {
    const ControlRange& range = controls.list()[c];
    for (std::size_t m = 0; m < 2; ++m)
      row[c] += 0.5f * fade * poses[keys + m][c] *
                std::max(0.0f, noise(900 * seed + m, 0.4f * time + 0.5f * static_cast<float>(m)));
    Draw own(seed + 77, c);
    if (own.unit() < 0.35f) {
      const float size = own.between(0.05f, 0.25f), pace = own.between(0.7f, 1.8f);
      row[c] += fade * size * 0.5f * (range.maximum - range.minimum) * noise(seed * 100000 + c, pace * time);
    }
    row[c] = std::clamp(row[c], range.minimum, range.maximum);
  }
  return row;
}

}  // namespace

std::vector<Shot> make_shots(const ControlList& controls) {
  std::vector<Shot> shots;
  for (const ShotPlan& plan : plans()) {
    Shot& shot = shots.emplace_back();
    shot.name = plan.name;
    const std::vector<std::vector<float>> poses = poses_of(plan, controls);
    for (std::size_t frame = 0; frame < plan.frames; ++frame) {
      const float time = static_cast<float>(static_cast<double>(frame) / shot_fps);
      const std::vector<float> row = frame_of(plan, poses, shots.size(), time, controls);
      shot.frames.insert(shot.frames.end(), row.begin(), row.end());
    }
  }
  return shots;
}

}  // namespace rigs::production
