// The joints of a rig: those that a host moves, and those that the controls do.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/character.h"
#include "model/mesh.h"

namespace fb::bake {

struct RigJoints {
  // The rig's index of each of the character's joints, which a host moves, and of each driven one.
  std::vector<std::uint32_t> host, driven;
  // By driven joint: the character's joint that it hangs on, or no_joint.
  std::vector<std::uint32_t> holders;
  // By driven joint: from the axes that the rig gives it to those of its frame, which are straightened.
  std::vector<Frame<double>> straight;

  std::size_t count() const { return host.size() + driven.size(); }
};

// A skin in which vertices follow places[joint] in place of a joint, and nothing where that is no_joint.
Skin mapped_skin(const Skin& skin, std::span<const std::uint32_t> places);

// Whether each joint has numbers, or is below one that has: then no host moves any. joints: they may come before their
// parents or name some that there are not.
bool all_driven(std::span<const Joint> joints, std::span<const std::uint32_t> numbers);

// Parts the joints and the skin of a character in those that stay, and those that go into the mesh as driven joints.
// `numbers`: of each joint, see DrivenJoint::numbers; those without any are the host's, unless they are below a driven
// one. Vertices that followed a driven joint follow the one that it hangs on. Takes what joints do at rest out of the
// mesh's points, whose carriers are not there yet. Fails with bad_data, naming joint or vertex, where driven joints
// hang on none of the host's although there are some, or the blend of a vertex cannot be inverted at rest.
RigJoints part_joints(std::span<const std::uint32_t> numbers, Character& character, Mesh& rest);

// Takes what the host's joints do out of positions, in place, and finds the numbers of driven ones. `frames`: of all
// joints of the rig, in the space of the positions. Fails with bad_data, naming joint or vertex, as
// find_joint_numbers() does, and where the blend of a vertex cannot be inverted.
void take_out_joints(const RigJoints& joints, const Character& character, const Mesh& rest,
                     std::span<const Frame<double>> frames, std::span<float> positions, std::span<float> numbers);

}  // namespace fb::bake
