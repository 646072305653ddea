// Blendshapes that stand for controls: the face with one control moved.
#pragma once

#include <string>
#include <vector>

#include "commands/pose_evaluator.h"
#include "export/morph_targets.h"

namespace fb::tool {

// A control by itself at an end of its range, where the weight of its shape is 1.
struct ControlShape {
  std::size_t control = 0;
  float rest = 0, value = 1;
  bool one_sided = false;  // its weight is 0 on the other side of rest, where another shape stands for the control
  std::string name;

  // How far the control is on the way from rest to there.
  float weight(float control_value) const;
};

// One shape a control: at its maximum, or at its minimum where it rests at the maximum. Weights are below 0 on the
// other side of rest.
std::vector<ControlShape> shapes_of_controls(const facebaker::Model& model, bool arkit_names);

// One shape for each end of a control's range that is not its rest: "name" at the maximum, "name-" at the minimum.
// Weights are 0 to 1.
std::vector<ControlShape> shapes_of_both_ends(const facebaker::Model& model, bool arkit_names);

// The poses of the shapes: shapes x controls.
std::vector<float> poses_of(const facebaker::Model& model, const std::vector<ControlShape>& shapes);

// The weights of all shapes in poses (poses x controls): poses x shapes.
std::vector<float> weights_of(const std::vector<ControlShape>& shapes, std::span<const float> poses,
                              std::size_t controls);

// The shapes of one mesh that move it, named, with their normals, and the weights of poses.
MorphTargets targets_of(PoseEvaluator& evaluator, const std::vector<ControlShape>& shapes, std::span<const float> poses,
                        std::size_t mesh);

}  // namespace fb::tool
