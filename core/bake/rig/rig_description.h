#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bake/rig/rig_joints.h"
#include "bake/rig/source.h"
#include "facebaker/facebaker_rig.h"
#include "model/character.h"
#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Size of an fb_rig before texture coordinates were added to it: what every plugin fills.
inline constexpr std::size_t smallest_rig = offsetof(fb_rig, uv_count);

// The declaration of a rig, copied out of the C structs.
struct RigDescription {
  RigSchema schema;
  Mesh rest;  // with the vertices that carry numbers
  Character character = {};
  std::vector<Clip> clips;
  // evaluate_skinned is called, and what joints do is taken out; rest is without.
  bool skinned = false;
  RigJoints joints = {};            // where skinned
  std::size_t preferred_block = 0;  // poses, see Source::preferred_block
  std::string version = {};         // see Source::version
  std::vector<std::string> notes = {};
};

// Copies and checks everything a rig declares; evaluates nothing. Fails with status rig, naming the field, control,
// polygon, clip or frame: another ABI, null pointers, zero counts, doubled names, bad ranges, bad polygons, clips with
// values that are not finite or outside their range.
RigDescription describe(const fb_rig& rig);

}  // namespace fb::bake
