#include <algorithm>

#include "bake/rig/random_pose.h"
#include "bake/sampling/pose_generators.h"
#include "bake/sampling/sampling.h"

namespace fb::bake {
namespace {

std::vector<float> random_poses(const RigSchema& schema, std::uint64_t seed, Stream use, float probability,
                                std::size_t poses) {
  std::vector<float> all;
  for (std::size_t i = 0; i < poses; ++i) {
    Random random = open_stream(seed, use, i);
    const std::vector<float> pose = random_pose(schema, probability, random);
    all.insert(all.end(), pose.begin(), pose.end());
  }
  return all;
}

// In each shot two controls of five are active: each moves between random keys, toward one end of its range and up to a
// largest value of its own.
std::vector<float> synthetic_shots(const RigSchema& schema, std::uint64_t seed, std::size_t shots, std::size_t frames) {
  constexpr std::size_t step = 10;
  std::vector<float> all;
  for (std::size_t shot = 0; shot < shots; ++shot) {
    Random random = open_stream(seed, Stream::synthetic_shots, shot);
    const std::size_t width = schema.control_count(), keys = frames / step + 2;
    std::vector<float> poses(keys * width);
    for (std::size_t c = 0; c < width; ++c) {
      const Control& control = schema.controls[c];
      const bool active = random.uniform() < 0.4f, up = draw_end(control, random);
      const float size = random.uniform(0.2f, 1.0f);
      for (std::size_t key = 0; key < keys; ++key)
        poses[key * width + c] = active ? value_toward(control, up, size * random.uniform()) : control.rest;
    }
    const std::vector<float> shot_poses = interpolate_keys(poses, width, step, frames);
    all.insert(all.end(), shot_poses.begin(), shot_poses.end());
  }
  return all;
}

}  // namespace

std::vector<Clip> make_test_poses(const RigSchema& schema, std::uint64_t seed, std::size_t poses) {
  constexpr std::size_t shot_frames = 40;
  const std::size_t random = poses * 3 / 10, shots = poses - 2 * random;
  std::vector<float> shot_poses = synthetic_shots(schema, seed, (shots + shot_frames - 1) / shot_frames, shot_frames);
  shot_poses.resize(shots * schema.control_count());
  return {{"random_15", ClipKind::dense, Split::test, 30, random,
           random_poses(schema, seed, Stream::random_15, 0.15f, random)},
          {"random_35", ClipKind::dense, Split::test, 30, random,
           random_poses(schema, seed, Stream::random_35, 0.35f, random)},
          {"synthetic_shots", ClipKind::shot, Split::test, 30, shots, std::move(shot_poses)}};
}

}  // namespace fb::bake
