#pragma once

#include "model/mesh.h"
#include "render/mesh_view.h"

namespace fb::tool {

inline MeshView mesh_view_of(const Mesh& mesh) {
  return {mesh.points, mesh.polygon_sizes, mesh.polygon_corners, mesh.uvs, mesh.uv_corners};
}

}  // namespace fb::tool
