// The control values a command line asks for.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "model/rig_schema.h"

namespace fb::tool {

struct PoseRequest {
  std::vector<std::string> set;  // "NAME=VALUE"
  std::string clip;              // path of a .npy of frames x controls; empty: one frame, at rest
};

struct Poses {
  std::vector<float> controls;  // frames x controls, all within their ranges
  std::size_t frames = 0;
  std::size_t clamped = 0;         // values that were not
  std::vector<std::string> notes;  // sentences that say which
};

// The clip, or the rest pose, with the values that are set put into every frame. Fails by name on an unknown control,
// naming the closest there is, and on what is no number.
Poses read_poses(const PoseRequest& request, const RigSchema& schema);

}  // namespace fb::tool
