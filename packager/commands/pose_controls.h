// Poses as a command line gives them.
#pragma once

#include <cstddef>
#include <facebaker/facebaker.hpp>
#include <string>
#include <vector>

namespace fb::tool {

struct PoseRequest {
  std::vector<std::string> set;  // "NAME=VALUE"
  std::string clip;              // path of a .npy of frames x controls; empty: one frame, at rest
};

struct Poses {
  std::vector<float> controls;  // frames x controls, within their ranges
  std::size_t frames = 0;
  std::size_t clamped = 0;         // values that were outside
  std::vector<std::string> notes;  // sentences: which controls were
};

// The controls of a model, in order; their strings are the model's.
std::vector<fb_control> controls_of(const facebaker::Model& model);

// The clip, or the rest pose, with the values that are set put into every frame. Fails by name on an unknown control,
// with the closest one there is, and on what is no number.
Poses read_poses(const PoseRequest& request, const facebaker::Model& model);

}  // namespace fb::tool
