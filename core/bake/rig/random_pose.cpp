#include "bake/rig/random_pose.h"

#include <algorithm>

namespace fb::bake {

std::vector<float> random_pose(const RigSchema& schema, float active, Random& random) {
  std::vector<float> pose;
  for (const Control& control : schema.controls) {
    const bool on = random.uniform() < active;
    const float value = random_value(control, random);
    pose.push_back(on ? value : control.rest);
  }
  return pose;
}

float random_value(const Control& control, Random& random) {
  return std::clamp(random.uniform(control.minimum, control.maximum), control.minimum, control.maximum);
}

}  // namespace fb::bake
