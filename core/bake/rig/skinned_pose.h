#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "model/joints.h"

namespace fb::bake {

// What each joint does to vertices: where it is x its inverse bind matrix.
std::vector<Frame<double>> joint_matrices(std::span<const Joint> joints, std::span<const Frame<double>> frames);

// Takes the motion of joints out of positions in place (3 x vertices): linear blend skinning backwards, by the inverse
// of each vertex's blend of matrices. `frames`: where each joint is, in the space of the positions. Gives the first
// vertex whose blend cannot be inverted, and leaves it and those after it as they are.
std::optional<std::size_t> remove_skin(std::span<const Joint> joints, const Skin& skin,
                                       std::span<const Frame<double>> frames, std::span<float> positions);

}  // namespace fb::bake
