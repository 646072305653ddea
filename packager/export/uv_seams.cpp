#include "export/uv_seams.h"

#include <map>

#include "base/checked.h"

namespace fb::tool {

std::vector<float> SplitMesh::with_copies(std::span<const float> vectors) const {
  std::vector<float> all(vectors.begin(), vectors.end());
  for (const std::uint32_t vertex : copied)
    all.insert(all.end(), {vectors[3 * vertex], vectors[3 * vertex + 1], vectors[3 * vertex + 2]});
  return all;
}

SplitMesh split_at_seams(const MeshView& mesh) {
  SplitMesh split;
  if (mesh.uvs.empty()) {
    split.triangles = mesh.triangles();
    return split;
  }
  constexpr std::uint32_t none = UINT32_MAX;
  std::vector<std::uint32_t> uv_of(mesh.vertex_count(), none);              // of each vertex and copy
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> copies;  // by vertex and texture coordinate
  std::vector<std::uint32_t> corners(mesh.polygon_corners.begin(), mesh.polygon_corners.end());
  for (std::size_t c = 0; c < mesh.polygon_corners.size(); ++c) {
    const std::uint32_t vertex = mesh.polygon_corners[c], uv = mesh.uv_corners[c];
    if (uv_of[vertex] == none) uv_of[vertex] = uv;
    if (uv_of[vertex] == uv) continue;
    const auto [copy, added] = copies.try_emplace({vertex, uv}, checked_u32(uv_of.size(), "vertices"));
    if (added) {
      split.copied.push_back(vertex);
      uv_of.push_back(uv);
    }
    corners[c] = copy->second;
  }
  for (const std::uint32_t uv : uv_of) {
    split.uvs.push_back(uv == none ? 0 : mesh.uvs[2 * std::size_t(uv)]);
    split.uvs.push_back(uv == none ? 0 : mesh.uvs[2 * std::size_t(uv) + 1]);
  }
  MeshView copied_mesh = mesh;
  copied_mesh.polygon_corners = corners;
  split.triangles = copied_mesh.triangles();
  return split;
}

}  // namespace fb::tool
