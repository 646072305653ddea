// Poses as a command line gives them.
#pragma once

#include <cstddef>
#include <facebaker/facebaker.hpp>
#include <optional>
#include <string>
#include <vector>

namespace fb::tool {

struct PoseRequest {
  std::vector<std::string> set;  // "NAME=VALUE"
  std::string clip;              // path of a .npy of frames x controls
  std::string live_link;      // path of a recording of Live Link Face, in place of a clip; neither: one frame at rest
  std::optional<double> fps;  // frames a second; none: 30 for a clip, as recorded for a recording

  const std::string& animation() const { return clip.empty() ? live_link : clip; }
};

struct Poses {
  std::vector<float> controls;  // frames x controls, within their ranges
  std::size_t frames = 0;
  double fps = 30;
  std::size_t clamped = 0;         // values that were outside
  std::vector<std::string> notes;  // sentences: which controls were, and about a recording
};

// The controls of a model, in order; their strings are the model's.
std::vector<fb_control> controls_of(const facebaker::Model& model);

// The clip, the recording, or the rest pose, with the values that are set put into every frame. Fails by name on an
// unknown control, with the closest one there is, and on what is no number.
Poses read_poses(const PoseRequest& request, const facebaker::Model& model);

}  // namespace fb::tool
