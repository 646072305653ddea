// Which joints of a glTF file are controls.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bake/rig/gltf/gltf_joints.h"
#include "bake/rig/gltf/gltf_options.h"
#include "bake/rig/gltf/joint_controls.h"

namespace fb::bake {

class JointChoice {
 public:
  // `morphs`: whether the file has morph targets. Fails on a name that no node has.
  JointChoice(const GltfOptions& options, const GltfFile& file, bool morphs);

  // Whether joints are controls, and positions after skinning.
  bool controls() const { return controls_; }
  // Whether the options say what joints are.
  bool told() const { return told_; }
  // Of each node, whether it moves: by animations, or by controls.
  const std::vector<bool>& moving() const { return moving_; }
  // Those nodes, of the ones that move, which move vertices. `points`: of all vertices, before skinning. Fails on a
  // chosen node that moves none, and, where joints are controls, on one whose matrix shears.
  std::vector<MovedNode> moved(const GltfScene& scene, const GltfJoints& joints, std::span<const float> points) const;

 private:
  const GltfFile& file_;
  bool told_, controls_ = false, chosen_ = false;
  std::vector<bool> moving_;
};

}  // namespace fb::bake
