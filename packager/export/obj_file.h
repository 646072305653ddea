#pragma once

#include <filesystem>
#include <span>

#include "export/character_view.h"

namespace fb::tool {

// Writes a Wavefront .obj: points of all meshes (3 x vertices) with the shortest digits that give the same floats, and
// for each mesh an object with its polygons and their texture coordinates, not triangulated. Where the character has
// materials, `usemtl` names that of each run of polygons; there is no .mtl file.
void write_obj(const std::filesystem::path& path, const CharacterView& character, std::span<const float> points);

}  // namespace fb::tool
