#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "render/mesh_view.h"

namespace fb::tool {

// Writes a Wavefront .obj with an object `name`: points (3 x vertices) with the shortest digits that give the same
// floats, and the polygons of the mesh with their texture coordinates, not triangulated.
void write_obj(const std::filesystem::path& path, const std::string& name, const MeshView& mesh,
               std::span<const float> points);

}  // namespace fb::tool
