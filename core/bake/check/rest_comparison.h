#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace fb::bake {

// How far points (3 x vertices) are from a rest mesh: the worst vertex, over the mesh's diagonal.
struct RestDistance {
  double largest = 0;
  std::size_t vertex = 0;
};
RestDistance distance_from(std::span<const float> rest, std::span<const float> points, double diagonal);

// What would explain points that ought to lie near a rest mesh and do not: other units (a factor), another up axis (a
// quarter turn), a place elsewhere, or another order of vertices. Half a sentence: "they are 100 times as large, as if
// in other units"; "" if nothing is known. `tolerance`: how near they lie then, over the diagonal.
std::string explain_distance(std::span<const float> rest, std::span<const float> points, double tolerance);

// A sentence if a mesh of this diagonal is no likely face or body in these units; nothing for units that are not known.
std::optional<std::string> suspicious_size(double diagonal, const std::string& units);

}  // namespace fb::bake
