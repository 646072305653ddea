// Positions after skinning, for rigs whose joints are controls.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "bake/rig/gltf/gltf_joints.h"
#include "bake/rig/gltf/joint_controls.h"

namespace fb::bake {

// Linear blend skinning (glTF 2.0, section 3.7.3.3) by joints of which some are controls. Immutable.
class SkinnedMorph {
 public:
  SkinnedMorph() = default;
  SkinnedMorph(const GltfJoints& joints, JointControls controls);

  const JointControls& controls() const { return controls_; }
  // How the controls move each joint, see JointControls::numbers.
  std::vector<std::uint32_t> numbers() const;
  // Where the joints are. `values`: one of each control of a joint.
  std::vector<Eigen::Affine3d> places(std::span<const float> values) const;
  // Skins positions before skinning (3 x vertices) in place.
  void apply(std::span<const Eigen::Affine3d> places, std::span<float> positions) const;
  // Of all that decides where it puts positions.
  std::uint64_t hash(std::uint64_t seed) const;

 private:
  static constexpr std::size_t still = SIZE_MAX;

  JointControls controls_;
  std::vector<std::uint32_t> parents_;  // of joints; no_joint: none
  std::vector<std::size_t> moved_;      // of joints: which of the moved nodes, or still
  std::vector<Eigen::Affine3d> locals_, inverse_binds_;
  Skin skin_;
};

}  // namespace fb::bake
