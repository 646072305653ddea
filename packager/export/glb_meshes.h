#pragma once

#include <span>

#include "export/character_view.h"
#include "export/glb_buffer.h"
#include "export/morph_targets.h"

namespace fb::tool {

// Adds a mesh of a character in a pose (`points`: 3 x vertices of the mesh), with a primitive for each run of polygons,
// and its morph targets with the weights of the first frame. Primitives share vertices: those of the mesh in order,
// then copies of those on UV seams. Positions are exact. A mesh
// without polygons becomes points.
void add_mesh(tinygltf::Model& model, GlbBuffer& buffer, const CharacterView& character, std::size_t index,
              std::span<const float> points, const MorphTargets& morph);

}  // namespace fb::tool
