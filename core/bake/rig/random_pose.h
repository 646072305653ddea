#pragma once

#include <vector>

#include "base/random.h"
#include "model/rig_schema.h"

namespace fb::bake {

// A pose in which each control is, with probability `active`, anywhere in its range, and else at rest.
std::vector<float> random_pose(const RigSchema& schema, float active, Random& random);

// Any value of a control's range; all are equally likely.
float random_value(const Control& control, Random& random);

}  // namespace fb::bake
