// The numbers that a pose has beside positions, channels and those of driven joints, as vertices behind the surface,
// three numbers a vertex: a bake then learns all alike.
#pragma once

#include <cstddef>
#include <span>

#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Sets the scales of the channels, whose ranges are then an eighth of the diagonal long, and adds the vertices to the
// rest mesh, which has none yet and has been checked. Those of driven joints: add_joint_vertices().
void add_channel_vertices(RigSchema& schema, Mesh& rest);

// How many numbers a pose has: the channels, then those of driven joints.
std::size_t carried_count(const RigSchema& schema, const Mesh& rest);

// Sets the points of poses (poses x 3 x all vertices) from positions of the surface (poses x 3 x its vertices) and
// numbers (poses x carried_count()), of which channels are clamped to their ranges. What is not finite stays so.
// `rest`: with the vertices that carry numbers.
void join_carried(const RigSchema& schema, const Mesh& rest, std::span<const float> positions,
                  std::span<const float> numbers, std::size_t poses, std::span<float> points);

// The reverse.
void split_carried(const RigSchema& schema, const Mesh& rest, std::span<const float> points, std::size_t poses,
                   std::span<float> positions, std::span<float> numbers);

}  // namespace fb::bake
