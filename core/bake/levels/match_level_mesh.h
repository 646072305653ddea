#pragma once

#include <span>
#include <string>

#include "bake/levels/level_plan.h"

namespace fb::bake {

// A mesh that was given for a level of detail, and what it is called in messages.
struct LevelMesh {
  Mesh mesh;
  std::string name;
};

// A plan with the polygons of given meshes, each coarser than the one before. Their corners become vertices of `rest`
// at the same place, up to 1e-4 of the diagonal: of several the one with the nearest texture coordinates, then the
// lowest. A polygon gets the material that most of its corners have in `rest`, and belongs to the mesh that its
// vertices belong to. `kept`: see simplified_levels. Fails with bad_data, naming mesh and vertex, where there is no
// such vertex, and naming mesh and polygon where one has vertices of two meshes.
LevelPlan matched_levels(const Mesh& rest, std::span<const LevelMesh> meshes, std::span<const std::uint32_t> kept);

}  // namespace fb::bake
