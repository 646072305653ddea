// Poses of the production rig: what somebody records of it to bake from, and its animation.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "production/production_controls.h"

namespace rigs::production {

// `count` poses x controls, as somebody records them who knows the rig: 15 % single controls at halves and ends of
// their ranges, 35 % with 4 to 24 controls of the whole face, 30 % expressions of one to three control groups, most of
// them on both sides, 20 % with many controls, none of them far. Nine poses of ten have at most five controls beyond
// 0.6 of their range, and there are no shots. The first poses of a longer recording are those of a shorter one.
std::vector<float> recorded_poses(const ControlList& controls, std::uint64_t seed, std::size_t count);
// The same without single controls.
std::vector<float> random_poses(const ControlList& controls, std::uint64_t seed, std::size_t count);

struct Shot {
  std::string name;
  std::vector<float> frames;  // frames x controls
};
constexpr double shot_fps = 24;

// "talking", 300 frames, and "expressive", 288: keys eased into one after the other, below them moods that come and go,
// and a third of all controls moving a little of their own.
std::vector<Shot> make_shots(const ControlList& controls);

}  // namespace rigs::production
