#include "bake/rig/gltf/joint_choice.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>

#include "bake/rig/gltf/joint_noise.h"
#include "base/match_names.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {

JointChoice::JointChoice(const GltfOptions& options, const GltfFile& file, bool morphs)
    : file_(file),
      told_(options.joints != JointUse::automatic),
      chosen_(!options.control_joints.empty()),
      moving_(animated_nodes(file.model())) {
  if (chosen_ && options.joints == JointUse::ignored)
    fail(Status::invalid_argument, "joints are ignored, and \"%s\" is to be a control",
         shown(options.control_joints[0]).c_str());
  const bool animated = std::ranges::find(moving_, true) != moving_.end();
  controls_ =
      options.joints == JointUse::controls || chosen_ || (options.joints == JointUse::automatic && !morphs && animated);
  if (!chosen_) return;
  moving_.assign(moving_.size(), false);
  std::vector<std::string> names;
  for (const tinygltf::Node& node : file.model().nodes)
    if (!node.name.empty()) names.push_back(node.name);
  for (const std::string& name : options.control_joints) {
    bool found = false;
    for (std::size_t n = 0; n < moving_.size(); ++n)
      if (file.model().nodes[n].name == name) found = moving_[n] = true;
    if (!found)
      fail(Status::not_found, "it has no joint or node \"%s\"%s", shown(name).c_str(),
           names_there_are(name, names).c_str());
  }
}

std::vector<MovedNode> JointChoice::moved(const GltfScene& scene, const GltfJoints& joints,
                                          std::span<const float> points) const {
  std::vector<MovedNode> moved;
  for (std::size_t n = 0; n < moving_.size(); ++n) {
    if (!moving_[n]) continue;
    const tinygltf::Node& node = file_.model().nodes[n];
    const auto joint = joints.moving_joint(n);
    if (!joint && chosen_) fail(Status::bad_data, "joint \"%s\" moves no vertex", shown(node.name).c_str());
    if (!joint) continue;
    const std::string& name = joints.joints()[*joint].name;
    const auto parts = parts_of(node);
    if (!parts && !controls_) continue;
    if (!parts)
      fail(Status::unsupported, "the matrix of joint \"%s\" shears or flattens: it is no control", shown(name).c_str());
    const int parent = scene.parent(n);
    const double scale = parent < 0 ? 1 : scene.world(static_cast<std::size_t>(parent)).linear().norm() / std::sqrt(3);
    moved.push_back({n, name, *parts, chosen_, scale});
  }
  measure_nodes(moved, scene, joints, points);
  return moved;
}

}  // namespace fb::bake
