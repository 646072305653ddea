// The poses that the shots go through: visemes, expressions, exercises.
#pragma once

#include <string>
#include <vector>

#include "controls.h"

namespace sample_face {

// Every control's value in a pose; throws std::out_of_range naming the pose if there is none.
std::vector<float> shot_pose(const std::string& name, const Controls& controls);

}  // namespace sample_face
