#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/mesh.h"

namespace fb {

struct PackedModel;

// A point of a level's surface: corner 0 of a triangle with weight 256 - weights[0] - weights[1], its corners 1 and 2
// with these weights, all in 256ths.
struct SurfacePoint {
  std::uint32_t triangle = 0;  // counted through the fans of the level's polygons
  std::array<std::uint8_t, 2> weights = {};
  bool operator==(const SurfacePoint&) const = default;
};

// The polygons of one mesh of the character at a level.
struct LevelPart {
  std::uint32_t polygons = 0;
  std::vector<MaterialRun> materials = {};  // of all of them, in order; empty: none
  bool operator==(const LevelPart&) const = default;
};

// A character at fewer vertices and with fewer coefficients than the level before it; level 0 is the whole. Networks
// and basis are shared: vertices are ordered so that those of a level are the first in baked order.
struct DetailLevel {
  std::uint32_t vertices = 0;                  // the first so many in baked order: whole row blocks
  std::vector<std::uint32_t> polygon_sizes;    // corners of each polygon, >= 3
  std::vector<std::uint32_t> polygon_corners;  // vertices of the mesh, of this level
  std::vector<std::uint32_t> uv_corners = {};  // see Mesh::uv_corners
  std::vector<LevelPart> parts = {};           // one for each of Mesh::parts
  std::vector<SurfacePoint> points = {};       // where the vertices that the level before has besides these come to lie
                                               // on this level's surface, in baked order
  std::vector<std::uint8_t> used_coefficients = {};  // by coefficient that is not direct: 0 if it counts as 0, else 1

  std::vector<std::uint32_t> triangles() const { return triangle_fans(polygon_sizes, polygon_corners); }
  bool operator==(const DetailLevel&) const = default;
};

inline constexpr std::size_t max_detail_levels = 15;

// How many coefficients move vertices of a level of the model.
std::size_t coefficients_of(const PackedModel& model, const DetailLevel& level);

// Fails, naming the level, unless the levels of a model fit its other parts and each other; these have been checked.
void check_levels(const PackedModel& model);

}  // namespace fb
