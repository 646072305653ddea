#pragma once

#include <span>

#include "bake/levels/level_plan.h"

namespace fb::bake {

// Levels of about so many of the vertices, `shares` of 1 and each below the one before, by edge collapse onto existing
// vertices (meshoptimizer), of each mesh of the character for itself. `points`: 3 floats a vertex, by which distances
// are measured. Borders of texture coordinates and of materials stay. Vertices of `kept` and those without polygons are
// in every level. A level may have more vertices than asked for where the surface allows no fewer. Surface points are
// not found.
LevelPlan simplified_levels(const Mesh& rest, std::span<const float> points, std::span<const double> shares,
                            std::span<const std::uint32_t> kept);

// Sets `coarsest` by the polygons of a plan's levels; see simplified_levels for `kept`.
void find_coarsest_levels(const Mesh& rest, std::span<const std::uint32_t> kept, LevelPlan& plan);

}  // namespace fb::bake
