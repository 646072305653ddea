#include "shots.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "shot_poses.h"
#include "vec3.h"

namespace sample_face {
namespace {

// A key: from this time on (seconds) the face eases into the pose over `ease` seconds and stays.
struct Key {
  float time;
  const char* pose;
  float amount = 1, ease = 0.3f;
};

struct ShotPlan {
  const char* name;
  ShotSplit split;
  double fps;
  int frames;
  float life;            // strength of the underlay of noise
  const char* moods[2];  // poses that come and go under the keys
  std::vector<Key> keys;
};

const std::vector<ShotPlan>& plans() {
  static const std::vector<ShotPlan> all = {
      {"greeting",
       ShotSplit::train,
       30,
       180,
       0.8f,
       {"smile", "look_up"},
       {{0.3f, "look_left"},
        {0.9f, "smile", 0.7f},
        {1.5f, "EE", 0.8f, 0.12f},
        {1.7f, "LL", 0.8f, 0.12f},
        {1.9f, "OH", 0.9f, 0.15f},
        {2.3f, "blink", 1, 0.1f},
        {2.5f, "smile", 1, 0.25f},
        {3.4f, "AA", 0.6f, 0.15f},
        {3.6f, "MM", 0.9f, 0.12f},
        {3.9f, "EE", 0.9f, 0.15f},
        {4.3f, "smirk", 1, 0.3f},
        {5.3f, "rest", 1, 0.4f}}},
      {"dialogue",
       ShotSplit::train,
       24,
       240,
       0.9f,
       {"anger", "smirk"},
       {{0.2f, "MM", 1, 0.12f},        {0.4f, "AA", 1, 0.14f},    {0.65f, "TH", 1, 0.12f},   {0.9f, "OO", 1, 0.15f},
        {1.2f, "FV", 1, 0.12f},        {1.4f, "EE", 1, 0.14f},    {1.8f, "LL", 1, 0.13f},    {2.0f, "OH", 1, 0.15f},
        {2.4f, "blink", 1, 0.1f},      {2.6f, "AA", 1.1f, 0.15f}, {2.9f, "MM", 1, 0.12f},    {3.1f, "OO", 0.9f, 0.15f},
        {3.4f, "look_up", 0.8f, 0.3f}, {4.0f, "EE", 1, 0.14f},    {4.3f, "FV", 1, 0.12f},    {4.5f, "AA", 0.8f, 0.15f},
        {4.9f, "anger", 0.6f, 0.3f},   {5.5f, "OH", 1, 0.15f},    {5.8f, "MM", 1, 0.12f},    {6.1f, "AA", 1, 0.15f},
        {6.5f, "TH", 1, 0.13f},        {6.8f, "EE", 0.8f, 0.15f}, {7.3f, "sad", 0.7f, 0.4f}, {8.4f, "OO", 0.7f, 0.2f},
        {9.0f, "rest", 1, 0.5f}}},
      {"smile_and_laugh",
       ShotSplit::train,
       30,
       210,
       0.9f,
       {"smile", "bend_left"},
       {{0.4f, "smile", 0.6f, 0.5f},
        {1.2f, "smirk", 1, 0.3f},
        {1.9f, "laugh", 1, 0.2f},
        {2.2f, "laugh", 0.6f, 0.12f},
        {2.4f, "laugh", 1, 0.12f},
        {2.65f, "laugh", 0.55f, 0.12f},
        {2.9f, "laugh", 1.1f, 0.14f},
        {3.2f, "scrunch", 0.6f, 0.2f},
        {3.7f, "laugh", 0.9f, 0.2f},
        {4.3f, "smile", 0.9f, 0.3f},
        {5.0f, "blink", 1, 0.1f},
        {5.2f, "smile", 0.5f, 0.3f},
        {6.2f, "rest", 1, 0.5f}}},
      {"look_around",
       ShotSplit::train,
       30,
       180,
       0.7f,
       {"surprise", "sad"},
       {{0.3f, "look_left", 1, 0.15f},
        {1.0f, "blink", 1, 0.1f},
        {1.15f, "look_right", 1, 0.15f},
        {2.0f, "look_up", 1, 0.2f},
        {2.7f, "blink", 1, 0.1f},
        {2.85f, "look_down", 1, 0.2f},
        {3.6f, "surprise", 0.5f, 0.2f},
        {4.4f, "look_left", 0.7f, 0.2f},
        {5.0f, "blink", 1, 0.1f},
        {5.3f, "rest", 1, 0.3f}}},
      {"anger_to_surprise",
       ShotSplit::train,
       24,
       192,
       1.0f,
       {"disgust", "bend_right"},
       {{0.4f, "anger", 0.6f, 0.6f},
        {1.2f, "anger", 1, 0.3f},
        {1.8f, "shout", 1, 0.15f},
        {2.6f, "disgust", 0.9f, 0.3f},
        {3.3f, "anger", 1, 0.3f},
        {4.0f, "blink", 1, 0.1f},
        {4.2f, "surprise", 1, 0.15f},
        {5.3f, "surprise", 0.6f, 0.4f},
        {6.0f, "sad", 0.6f, 0.5f},
        {7.2f, "rest", 1, 0.5f}}},
      {"exercise",
       ShotSplit::train,
       30,
       250,
       0.6f,
       {"smirk", "surprise"},
       {{0.3f, "wide_open", 1, 0.4f},
        {1.1f, "scrunch", 1, 0.3f},
        {1.8f, "puff", 1, 0.3f},
        {2.5f, "suck", 1, 0.3f},
        {3.2f, "bend_left", 1, 0.35f},
        {4.0f, "bend_right", 1, 0.35f},
        {4.8f, "tongue", 1, 0.35f},
        {5.8f, "chew_left", 1, 0.25f},
        {6.2f, "chew_right", 1, 0.25f},
        {6.6f, "chew_left", 1, 0.25f},
        {7.2f, "pucker", 1, 0.3f},
        {7.8f, "rest", 1, 0.4f}}},
      {"whisper_and_pucker",
       ShotSplit::validation,
       30,
       165,
       0.9f,
       {"sad", "smile"},
       {{0.3f, "whisper", 1, 0.3f},
        {0.8f, "OO", 0.6f, 0.15f},
        {1.1f, "FV", 0.7f, 0.12f},
        {1.35f, "EE", 0.5f, 0.15f},
        {1.7f, "MM", 0.8f, 0.12f},
        {2.0f, "whisper", 1, 0.2f},
        {2.6f, "pucker", 1, 0.3f},
        {3.3f, "kiss", 1, 0.25f},
        {4.0f, "smile", 0.7f, 0.3f},
        {4.9f, "rest", 1, 0.4f}}},
      {"story",
       ShotSplit::test,
       24,
       216,
       1.0f,
       {"smile", "anger"},
       {{0.3f, "surprise", 0.6f, 0.25f},
        {0.8f, "OH", 1, 0.15f},
        {1.1f, "LL", 1, 0.12f},
        {1.3f, "EE", 0.9f, 0.14f},
        {1.7f, "smile", 0.8f, 0.25f},
        {2.3f, "AA", 1, 0.15f},
        {2.6f, "MM", 1, 0.12f},
        {2.8f, "OO", 1, 0.14f},
        {3.2f, "disgust", 0.9f, 0.3f},
        {4.0f, "TH", 1, 0.12f},
        {4.2f, "AA", 0.9f, 0.15f},
        {4.6f, "blink", 1, 0.1f},
        {4.8f, "laugh", 0.9f, 0.2f},
        {5.6f, "FV", 1, 0.14f},
        {5.9f, "shout", 0.7f, 0.2f},
        {6.6f, "sad", 0.9f, 0.4f},
        {7.5f, "smirk", 1, 0.35f},
        {8.3f, "rest", 1, 0.4f}}},
      {"clowning",
       ShotSplit::test,
       30,
       200,
       0.9f,
       {"scrunch", "smirk"},
       {{0.3f, "puff", 0.9f, 0.3f},
        {0.9f, "OO", 1, 0.15f},
        {1.3f, "tongue", 1, 0.25f},
        {2.0f, "bend_right", 0.9f, 0.3f},
        {2.6f, "wide_open", 0.8f, 0.25f},
        {3.2f, "kiss", 1, 0.25f},
        {3.9f, "laugh", 1, 0.2f},
        {4.5f, "chew_right", 1, 0.2f},
        {4.9f, "chew_left", 1, 0.2f},
        {5.3f, "surprise", 1, 0.15f},
        {6.1f, "rest", 1, 0.3f}}},
  };
  return all;
}

// Uniform in [0, 1), from a counter: the same everywhere.
float random_unit(std::uint64_t seed) {
  seed += 0x9e3779b97f4a7c15ull;
  seed = (seed ^ (seed >> 30)) * 0xbf58476d1ce4e5b9ull;
  seed = (seed ^ (seed >> 27)) * 0x94d049bb133111ebull;
  return float((seed ^ (seed >> 31)) >> 40) * 0x1p-24f;
}

// Smooth noise in [-1, 1] through random values once a unit of t.
float noise(std::uint64_t seed, float t) {
  const float cell = std::floor(t);
  const auto at = [&](float i) {
    return 2 * random_unit(seed * 0x100000001b3ull + std::uint64_t(std::int64_t(i))) - 1;
  };
  return mix(at(cell), at(cell + 1), smoothstep(0, 1, t - cell));
}

Shot make_shot(const ShotPlan& plan, std::uint64_t seed, const Controls& controls) {
  const auto& list = controls.list();
  Shot shot{plan.name, plan.split, plan.fps, std::size_t(plan.frames), {}};
  shot.values.resize(shot.frames * list.size());
  std::vector<std::vector<float>> poses;
  for (const Key& key : plan.keys) poses.push_back(shot_pose(key.pose, controls));
  const std::array<std::vector<float>, 2> moods = {shot_pose(plan.moods[0], controls),
                                                   shot_pose(plan.moods[1], controls)};
  for (std::size_t frame = 0; frame < shot.frames; ++frame) {
    float* row = &shot.values[frame * list.size()];
    const float time = float(double(frame) / plan.fps);
    const float fade = smoothstep(0, 0.5f, time) * smoothstep(float(plan.frames - 1) / float(plan.fps),
                                                              float(plan.frames - 1) / float(plan.fps) - 0.5f, time);
    for (std::size_t i = 0; i < list.size(); ++i) {
      // Each control arrives a little earlier or later than its neighbours: no face moves all at once.
      const float late = 0.08f * (random_unit(seed * 977 + i) - 0.5f);
      float value = 0;
      for (std::size_t k = 0; k < plan.keys.size(); ++k) {
        const Key& key = plan.keys[k];
        value = mix(value, poses[k][i] * key.amount, smoothstep(key.time + late, key.time + late + key.ease, time));
      }
      for (std::uint64_t k = 0; k < moods.size(); ++k)
        value += fade * 0.8f * moods[k][i] * std::max(0.0f, noise(seed * 7919 + k, 0.45f * time + 0.5f * float(k)));
      // The underlay: a fifth of the controls live in each shot, each at its own pace.
      if (random_unit(seed * 1315423911ull + i * 7 + 3) < 0.17f) {
        const float pace = 0.8f + 1.2f * random_unit(seed * 31 + i * 13);
        const bool motion = list[i].name.starts_with("blink") || list[i].name.starts_with("jaw_") ||
                            list[i].name.starts_with("look") || list[i].name.starts_with("eye") ||
                            list[i].name.starts_with("tongue") || list[i].name.starts_with("lips_");
        const float strength = plan.life * (motion ? 0.10f : 0.65f);
        value += fade * strength * noise(seed * 104729 + i, time * pace);
      }
      row[i] = std::clamp(value, list[i].two_sided ? -1.0f : 0.0f, 1.0f);
    }
  }
  return shot;
}

}  // namespace

std::vector<Shot> make_shots(const Controls& controls) {
  std::vector<Shot> shots;
  for (const ShotPlan& plan : plans()) shots.push_back(make_shot(plan, shots.size() + 1, controls));
  return shots;
}

}  // namespace sample_face
