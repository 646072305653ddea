// What driven joints do to the points of a source. Points hold positions as the rig gives them, with the numbers of its
// driven joints behind them; a bake learns displacements, which are before joints move vertices.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/driven_joints.h"
#include "model/mesh.h"

namespace fb::bake {

// Sets the scales of the numbers of the mesh's driven joints and adds the vertices that carry them. A unit of a
// coordinate moves what follows its joint by the root of the sum of squared distances of a unit, so that its error
// counts as much as those of all these vertices. Fails with bad_data, naming the joint, where axes of a frame at rest
// are not orthogonal, right-handed and of length 1.
void add_joint_vertices(Mesh& rest);

// Removes the vertices that carry numbers of driven joints.
void remove_joint_vertices(Mesh& rest);

// A frame with the origin of another and the orthogonal, right-handed axes of length 1 that are closest to its own, of
// which the last is turned round where they are mirrored; nothing where they are flat.
std::optional<Frame<double>> straightened(const Frame<double>& frame);

// The numbers of a pose from where its driven joints are, in the space of positions: the closest that their numbers
// can say, rotations by the polar decomposition (Higham, Computing the Polar Decomposition - with Applications, 1986).
// Joints are taken one after the other, so that each makes up for what its parents cannot say. Fails with bad_data,
// naming the joint, where one is mirrored or flat. A joint that is turned by more than 0.95 of a half turn, behind
// which its axis would jump, is taken to be turned by that: displacements make up for the rest. Outer rotations and
// pivots are 0.
void find_joint_numbers(const DrivenJoints& driven, std::span<const Frame<double>> frames, std::span<float> numbers);

// How joints moved, from the coordinates that carry their numbers: matrices that take vertices along.
std::vector<Frame<double>> joint_motions(const DrivenJoints& driven, std::span<const float> coordinates);

// Moves positions of the surface in place (3 x vertices) by linear blend skinning.
void add_driven_skin(const Mesh& rest, std::span<const Frame<double>> motions, std::span<double> positions);

// Takes what driven joints do out of the points of a pose, in place. Where the blend of a vertex cannot be inverted, it
// is taken to be at rest before joints move it.
void remove_driven_skin(const Mesh& rest, std::span<float> points);

// The same, then subtracts the rest mesh. With `vertices` (ascending), only theirs are made, and come first, one after
// the other; what is behind them is undefined.
void points_to_displacements(const Mesh& rest, std::span<float> points, std::span<const std::uint32_t> vertices = {});

}  // namespace fb::bake
