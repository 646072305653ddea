#pragma once

#include <vector>

#include "bake/check/dataset_files.h"
#include "bake/check/findings.h"

namespace fb::bake {

// What is wrong with controls, whether points are there or not: values outside their ranges, poses that occur more than
// once, poses to test with that are trained on too, controls that no training pose uses.
void check_poses(const DatasetFiles& files, Findings& findings);

// Controls of all clips of some splits whose controls could be read, frames x controls.
std::vector<float> poses_of(const DatasetFiles& files, std::initializer_list<Split> splits);

}  // namespace fb::bake
