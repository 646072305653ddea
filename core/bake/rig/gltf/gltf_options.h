#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fb::bake {

// What the joints of a glTF file are. Same numbers as FB_JOINTS_... in facebaker_source.h.
enum class JointUse : std::uint32_t {
  automatic = 0,  // controls where the file has no morph targets, and animations that move joints; otherwise ignored
  ignored = 1,    // the skeleton that carries the face: positions are before skinning
  controls = 2,   // controls of the face: positions are after skinning
};

// How a glTF file is read.
struct GltfOptions {
  JointUse joints = JointUse::automatic;
  std::vector<std::string> control_joints;  // names of the nodes that are controls; empty: those that animations move
  bool skip_broken = false;                 // meshes and animations that cannot be read are left out, with a note

  bool operator==(const GltfOptions&) const = default;
};

}  // namespace fb::bake
