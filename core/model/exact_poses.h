#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/rig_schema.h"

namespace fb {

// A pose that comes out as its rig gave it, within rounding: a correction is added to what the basis gives, with a
// weight that is 1 at the pose and fades with the distance of the controls, to 0 at the rest pose and at every other
// such pose. core/archive/EVALUATION.md defines every operation; core/bake/measure/keep_exact finds the numbers.
struct ExactPose {
  std::string name;                       // unique, not empty
  std::vector<float> controls;            // each within its range
  float falloff = 0;                      // above 0: 1 / the square of the distance at which the weight becomes 0
  float step = 0;                         // above 0: what a value of 1 stands for, in the units of positions
  std::vector<std::int32_t> values = {};  // by row of the basis, of at most largest_correction
  bool operator==(const ExactPose&) const = default;
};

inline constexpr std::size_t max_exact_poses = 1024;
inline constexpr std::int32_t largest_correction = 0xffffff;  // a float holds it exactly

// Where in its range a control is, from 0 to 1: what distances are measured in.
inline float place_in_range(const Control& control, float value) {
  const float clamped = value > control.minimum ? (value < control.maximum ? value : control.maximum) : control.minimum;
  return (clamped - control.minimum) / (control.maximum - control.minimum);
}
std::vector<float> places_in_ranges(const RigSchema& schema, std::span<const float> controls);

// The sum of squared differences of places, from the first control to the last.
float squared_distance(const float* a, const float* b, std::size_t controls);

// The weight of a correction: (1 - falloff x squared distance)^2, or 0 beyond.
float exact_weight(const float* places, const float* exact_places, std::size_t controls, float falloff);

// Fails, naming the pose, unless names are unique, controls within their ranges, numbers in range, values one a row,
// and all weights 0 at rest.
void check(std::span<const ExactPose> poses, const RigSchema& schema, std::size_t rows);

}  // namespace fb
