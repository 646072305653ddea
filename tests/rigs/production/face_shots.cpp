#include "production/draw.h"
#include "production/face_expressions.h"
#include "production/face_poses.h"

namespace rigs::production {
namespace {

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

std::vector<ShotPlan> plans() {
  return {
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
  for (const Key& key : plan.keys) poses.push_back(expression(key.pose, controls));
  for (const char* mood : plan.moods) poses.push_back(expression(mood, controls));
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
