#include "commands/control_shapes.h"

#include <algorithm>
#include <set>

#include "commands/pose_animation.h"
#include "commands/pose_controls.h"
#include "export/morph_normals.h"

namespace fb::tool {
namespace {

std::vector<std::string> shape_names(const std::vector<fb_control>& controls, bool arkit_names) {
  std::set<std::string> own;
  for (const fb_control& control : controls) own.insert(control.name);
  std::vector<std::string> names;
  for (const fb_control& control : controls) {
    const bool arkit = arkit_names && *control.arkit && !own.contains(control.arkit);
    names.emplace_back(arkit ? control.arkit : control.name);
  }
  return names;
}

}  // namespace

float ControlShape::weight(float control_value) const {
  const float reached = (control_value - rest) / (value - rest);
  return one_sided ? std::max(reached, 0.0f) : reached;
}

std::vector<ControlShape> shapes_of_controls(const facebaker::Model& model, bool arkit_names) {
  const std::vector<fb_control> controls = controls_of(model);
  const std::vector<std::string> names = shape_names(controls, arkit_names);
  std::vector<ControlShape> shapes;
  for (std::size_t c = 0; c < controls.size(); ++c) {
    const fb_control& control = controls[c];
    const float end = control.maximum > control.rest ? control.maximum : control.minimum;
    shapes.push_back({c, control.rest, end, false, names[c]});
  }
  return shapes;
}

std::vector<ControlShape> shapes_of_both_ends(const facebaker::Model& model, bool arkit_names) {
  const std::vector<fb_control> controls = controls_of(model);
  const std::vector<std::string> names = shape_names(controls, arkit_names);
  std::vector<ControlShape> shapes;
  for (std::size_t c = 0; c < controls.size(); ++c) {
    const fb_control& control = controls[c];
    if (control.maximum > control.rest) shapes.push_back({c, control.rest, control.maximum, true, names[c]});
    if (control.minimum < control.rest) shapes.push_back({c, control.rest, control.minimum, true, names[c] + "-"});
  }
  return shapes;
}

std::vector<float> poses_of(const facebaker::Model& model, const std::vector<ControlShape>& shapes) {
  const std::vector<float> rest = model.rest_controls();
  std::vector<float> poses;
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    poses.insert(poses.end(), rest.begin(), rest.end());
    poses[s * rest.size() + shapes[s].control] = shapes[s].value;
  }
  return poses;
}

std::vector<float> weights_of(const std::vector<ControlShape>& shapes, std::span<const float> poses,
                              std::size_t controls) {
  std::vector<float> weights;
  for (std::size_t first = 0; first < poses.size(); first += controls)
    for (const ControlShape& shape : shapes) weights.push_back(shape.weight(poses[first + shape.control]));
  return weights;
}

MorphTargets targets_of(PoseEvaluator& evaluator, const std::vector<ControlShape>& shapes, std::span<const float> poses,
                        std::size_t mesh) {
  if (shapes.empty()) return {};
  const std::vector<float> singles = poses_of(evaluator.model(), shapes);
  std::vector<std::size_t> moved;
  MorphTargets morph = moving_targets(frames_of(evaluator, singles, mesh), shapes.size(), moved);
  set_normals(morph, SingleMesh(evaluator.character(), mesh).view());
  for (const std::size_t s : moved) morph.names.push_back(shapes[s].name);
  morph.weights = chosen_weights(weights_of(shapes, poses, evaluator.model().control_count()), shapes.size(), moved);
  return morph;
}

}  // namespace fb::tool
