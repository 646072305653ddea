// Where the search for an alignment begins.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solve/sampled_surface.h"
#include "solve/similarity.h"

namespace fb::tool {

// The 24 rotations that turn axes to axes.
std::vector<Similarity> axis_rotations();

// The four rotations that turn the principal axes of some points to those of others; none where they are not distinct.
std::vector<Similarity> principal_rotations(std::span<const Vector3> from, std::span<const Vector3> to);

// For each of these rotations: sizes by the boxes' diagonals, the same and 0.6 and 1.6 times that, or `scale`; middle
// on middle, and the same along each end of each axis.
std::vector<Similarity> guesses_by_box(const std::vector<Similarity>& rotations, std::span<const Vector3> points,
                                       const BoundingBox& face, std::optional<double> scale);

// For points on the skin of a face, which look at the viewer: in front of its middle, and at three heights.
std::vector<Similarity> guesses_in_front(const std::vector<Similarity>& rotations, std::span<const Vector3> points,
                                         const BoundingBox& face, const std::string& up_axis, double scale);

// Of two similarities, the angle between their rotations, in degrees.
double degrees_apart(const Similarity& a, const Similarity& b);

}  // namespace fb::tool
