// Joints that the controls drive: what they are, and which vertices follow them. core/archive/EVALUATION.md defines how
// a pose moves them. The joints of joints.h are others: those that a host moves, outside of these.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "model/joints.h"

namespace fb {

// The numbers that a joint may have, in its own axes at rest: a rotation vector (radians), a translation, how much it
// is longer along each axis than at rest (0: as at rest), and where the pivot, which it turns about, is from its
// origin.
inline constexpr std::size_t numbers_a_joint = 12;
inline constexpr std::uint32_t joint_rotation = 0x7, joint_translation = 0x38, joint_scale = 0x1c0, joint_pivot = 0xe00;
// A rig declares no pivots: frames of a pose do not tell them from translations. A bake finds them.
inline constexpr std::uint32_t joint_numbers_of_rigs = joint_rotation | joint_translation | joint_scale;

// Rotations of a joint outside of its first, at most.
inline constexpr std::size_t most_outer_rotations = 15;
// Parents of parents, at most: each rounds once more.
inline constexpr std::size_t most_joint_depth = 256;
// What a weight of 1 is in archives, where weights are whole numbers.
inline constexpr std::uint32_t driven_weight_unit = 1u << 15;

struct DrivenJoint {
  std::string name;                 // unique among these, not empty
  std::uint32_t parent = no_joint;  // index of a driven joint before it; none: it is moved in the space of positions
  std::uint32_t numbers = 0;        // bit n: it has number n; it has those only that move
  Frame<float> rest = {};           // in the space of positions: its axes, of length 1, and its origin
  // Further rotations, each outside of those before it: bit n: it has number n, 0 to 2. Rotations that rigs make of
  // several in an order, as Euler angles are, are sums of what single controls do only one by one.
  std::vector<std::uint8_t> outer_rotations = {};
  bool operator==(const DrivenJoint&) const = default;

  // Its numbers in their order: those of `numbers`, then those of outer rotations, each as 0 to 11.
  std::vector<std::uint8_t> number_kinds() const;
  std::size_t number_count() const;
};

// In memory the numbers of all joints, in the order of joints and their bits, are carried by the last vertices of the
// mesh, three by each, behind those of channels: the coordinate that carries one is number / scale, 0 at rest.
struct DrivenJoints {
  std::vector<DrivenJoint> joints;
  std::vector<float> scales;  // of each number, above 0; empty where no vertices carry them yet
  // What each vertex of the surface follows. Weights are multiples of 1 / driven_weight_unit and sum to at most 1; what
  // is missing to 1 follows what does not move.
  Skin skin;
  bool operator==(const DrivenJoints&) const = default;

  bool empty() const { return joints.empty(); }
  std::size_t number_count() const;
};

// Rounds weights as the struct says, so that those of a vertex that sum to 1, to 1e-3, do so exactly; takes away what
// is 0 then. Tidies the skin.
void round_weights(Skin& skin);

// Fails, naming joint or vertex, on a name that is empty or occurs twice, a parent that is not before its joint, chains
// that are too long, what is not finite, unknown numbers, scales that are not one a number and above 0, and weights or
// joints of vertices that break the rules above. `vertices`: of the surface.
void check(const DrivenJoints& driven, std::size_t vertices);

}  // namespace fb
