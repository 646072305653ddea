// Normals and tangents at a level of detail, from those of the polygons of its level and of the next one.
#pragma once

#include <span>

#include "runtime/detail_layout.h"
#include "runtime/spread.h"

namespace fb::runtime {

// Unit vectors of vertices, or null ones, as their polygons give them.
struct DetailVectors {
  const float* of_level;                 // of its own vertices
  std::span<const std::uint32_t> order;  // where those are: by baked index; empty: in baked order
  const float* of_next;                  // of the vertices of choice.next, in baked order; not read without one
};

// Writes the vectors of the level's vertices, and with `all` of those that it does not have, to `to`, in baked order:
// vertices have the blend of both levels', where vectors of a vertex that a level does not have are interpolated from
// where it lies on its surface. So they are continuous in the level of detail, and at a level those of its polygons.
// normals: unit vectors in baked order that the results are made perpendicular to; null: they are not.
void blend_vectors(const DetailLayout& layout, const DetailChoice& choice, const DetailVectors& from, bool all,
                   const float* normals, const Spread& spread, float* to);

}  // namespace fb::runtime
