#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "model/mesh.h"

namespace fb {

// Writes a Wavefront .obj: `points` (3 x vertices) in vertex order with as many digits as a float needs, and the
// polygons of `mesh` as they are, quads kept, with their texture coordinates. `name` names the object.
void write_obj(const std::filesystem::path& path, const std::string& name, const Mesh& mesh,
               std::span<const float> points);

}  // namespace fb
