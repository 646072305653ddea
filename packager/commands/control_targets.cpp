#include "commands/control_targets.h"

#include <set>

#include "commands/pose_controls.h"
#include "export/morph_normals.h"

namespace fb::tool {
namespace {

// The value of a control at which its target's weight is 1.
float full_value(const fb_control& control) {
  return control.maximum > control.rest ? control.maximum : control.minimum;
}

std::vector<std::string> target_names(const std::vector<fb_control>& controls, bool arkit_names) {
  std::set<std::string> own;
  for (const fb_control& control : controls) own.insert(control.name);
  std::vector<std::string> names;
  for (const fb_control& control : controls) {
    const bool arkit = arkit_names && *control.arkit && !own.contains(control.arkit);
    names.emplace_back(arkit ? control.arkit : control.name);
  }
  return names;
}

// The pose of each control by itself: controls x controls.
std::vector<float> single_poses(const PoseEvaluator& evaluator, const std::vector<fb_control>& controls) {
  const std::vector<float> rest = evaluator.model().rest_controls();
  std::vector<float> poses;
  for (std::size_t c = 0; c < controls.size(); ++c) {
    poses.insert(poses.end(), rest.begin(), rest.end());
    poses[c * rest.size() + c] = full_value(controls[c]);
  }
  return poses;
}

// Weights of all controls in the poses: poses x controls.
std::vector<float> weights_of(std::span<const float> poses, const std::vector<fb_control>& controls) {
  std::vector<float> weights;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const fb_control& control = controls[i % controls.size()];
    weights.push_back((poses[i] - control.rest) / (full_value(control) - control.rest));
  }
  return weights;
}

}  // namespace

MorphedClip morph_controls(PoseEvaluator& evaluator, std::span<const float> controls, bool arkit_names) {
  const std::vector<fb_control> all = controls_of(evaluator.model());
  const std::vector<std::string> names = target_names(all, arkit_names);
  const std::vector<float> singles = single_poses(evaluator, all), weights = weights_of(controls, all);
  const std::size_t frames = evaluator.frames(controls);
  MorphedClip clip;
  for (std::size_t m = 0; m < evaluator.character().meshes.size(); ++m) {
    std::vector<std::size_t> moved;
    MorphTargets morph = moving_targets(frames_of(evaluator, singles, m), all.size(), moved);
    set_normals(morph, SingleMesh(evaluator.character(), m).view());
    for (const std::size_t c : moved) morph.names.push_back(names[c]);
    morph.weights = chosen_weights(weights, all.size(), moved);
    clip.error.add(error_of(morph, frames_of(evaluator, controls, m), frames, evaluator.parallel()));
    clip.meshes.push_back(std::move(morph));
  }
  return clip;
}

}  // namespace fb::tool
