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
  // Poses come after skinning, with frames of joints, and what joints do is taken out; rest is without.
  bool skinned = false;
  RigJoints joints = {};            // where skinned
  std::size_t preferred_block = 0;  // poses, see Source::preferred_block
  std::string version = {};         // see Source::version
  std::vector<std::string> notes = {};
};

// Makes a rig whose poses come after skinning one without: parts its joints, see part_joints(), takes what they do at
// rest out of the rest mesh, which has no carriers yet, and has the version say so. `numbers`: of each joint. Where all
// are driven, vertices may follow them by weights that sum to less than 1. Fails with bad_data, naming joint or vertex,
// as check() does, and where there is no skin.
void take_out_skin(RigDescription& rig, std::span<const std::uint32_t> numbers);

// Makes points of what such a rig gives for poses: positions (poses x 3 x surface vertices, changed here), channels
// (poses x channels) and frames of all its joints (poses x joints x 12), in the space of the positions. Throws
// PoseError for the first pose of which the joints cannot be taken out.
void take_out_poses(const RigDescription& rig, std::span<float> positions, std::span<const float> channels,
                    std::span<const float> frames, std::size_t poses, std::span<float> points);

// Copies and checks everything a rig declares; evaluates nothing. Fails with status rig, naming the field, control,
// polygon, clip or frame: another ABI, null pointers, zero counts, doubled names, bad ranges, bad polygons, clips with
// values that are not finite or outside their range.
RigDescription describe(const fb_rig& rig);

}  // namespace fb::bake
