// Levels of detail that a face is to have, before it is trained.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/detail_levels.h"
#include "model/packed_model.h"

namespace fb::bake {

struct LevelPlan {
  std::vector<DetailLevel> levels;     // their polygons; vertices, points and coefficients are not known yet
  std::vector<std::uint8_t> coarsest;  // by vertex of the mesh: the coarsest level that has it; 0: only the whole
  std::vector<SurfacePoint> points;    // by vertex: where it comes to lie on the first level that does not have it

  bool empty() const { return levels.empty(); }
  // The levels of a packed model whose vertices are ordered by `coarsest`, the highest first, with all coefficients.
  std::vector<DetailLevel> levels_of(const PackedModel& model) const;
};

// The points of all vertices in a pose, three floats each, in which those that move apart in any of some poses lie
// apart: rest points plus a mix of their displacements, each turned at random. Flat parts that move rigidly stay flat.
// What is near there belongs together in all poses. displacements: poses x 3 x vertices.
std::vector<float> mixed_points(std::span<const float> rest, std::span<const float> displacements, std::uint64_t seed);

// Fills plan.points: the nearest points of `points` (3 floats a vertex) on the triangles of each level around the
// nearest of its vertices along edges. Fails with bad_data, naming mesh and level, where a mesh has none.
void find_surface_points(const Mesh& rest, std::span<const float> points, LevelPlan& plan);

}  // namespace fb::bake
