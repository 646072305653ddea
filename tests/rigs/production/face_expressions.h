// Expressions and mouth shapes that the production rig's shots are keyed with.
#pragma once

#include <string>
#include <vector>

#include "production/production_controls.h"

namespace rigs::production {

// A pose, well within the ranges. Throws std::out_of_range where there is no expression of this name.
std::vector<float> expression(const std::string& name, const ControlList& controls);

}  // namespace rigs::production
