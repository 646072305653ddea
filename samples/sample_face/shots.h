// The sample face's shots: animation made from key poses, a living underlay and seeded noise.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "controls.h"

namespace sample_face {

enum class ShotSplit : std::int32_t { train = 0, validation = 1, test = 2 };  // FB_SPLIT_...

struct Shot {
  std::string name;
  ShotSplit split = ShotSplit::train;
  double fps = 30;
  std::size_t frames = 0;
  std::vector<float> values;  // frames x controls, within the controls' ranges
};

std::vector<Shot> make_shots(const Controls& controls);

}  // namespace sample_face
