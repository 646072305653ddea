// Channels of a rig as vertices behind its surface, three channels a vertex: a bake then learns both alike.
#pragma once

#include <cstddef>
#include <span>

#include "model/mesh.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Sets the scales of the channels, whose ranges are then an eighth of the diagonal long, and adds the vertices to the
// rest mesh, which has none yet and has been checked.
void add_channel_vertices(RigSchema& schema, Mesh& rest);

// Points of poses (poses x 3 x all vertices) from positions of the surface (poses x 3 x its vertices) and values of the
// channels (poses x channels), which are clamped to their ranges. What is not finite stays so.
void join_channels(const RigSchema& schema, std::span<const float> positions, std::span<const float> channels,
                   std::size_t poses, std::span<float> points);

// The reverse.
void split_channels(const RigSchema& schema, std::span<const float> points, std::size_t poses,
                    std::span<float> positions, std::span<float> channels);

}  // namespace fb::bake
