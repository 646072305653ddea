#include "export/uv_seams.h"

#include <map>

#include "base/checked.h"

namespace fb {

std::vector<float> SplitMesh::with_copies(std::span<const float> vectors) const {
  std::vector<float> all(vectors.begin(), vectors.end());
  for (const std::uint32_t vertex : copied)
    all.insert(all.end(), {vectors[3 * vertex], vectors[3 * vertex + 1], vectors[3 * vertex + 2]});
  return all;
}

SplitMesh split_at_seams(const Mesh& mesh) {
  SplitMesh split;
  if (mesh.uvs.empty()) {
    split.triangles = mesh.triangles();
    return split;
  }
  constexpr std::uint32_t none = UINT32_MAX;
  std::vector<std::uint32_t> pair_of(mesh.vertex_count(), none);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> copies;  // of a vertex with a pair
  Mesh parts = mesh;
  for (std::size_t c = 0; c < mesh.polygon_corners.size(); ++c) {
    const std::uint32_t vertex = mesh.polygon_corners[c], pair = mesh.uv_corners[c];
    if (pair_of[vertex] == none) pair_of[vertex] = pair;
    if (pair_of[vertex] == pair) continue;
    const auto [copy, added] = copies.try_emplace({vertex, pair}, checked_u32(pair_of.size(), "vertices"));
    if (added) {
      split.copied.push_back(vertex);
      pair_of.push_back(pair);
    }
    parts.polygon_corners[c] = copy->second;
  }
  for (const std::uint32_t pair : pair_of) {
    split.uvs.push_back(pair == none ? 0 : mesh.uvs[2 * std::size_t(pair)]);
    split.uvs.push_back(pair == none ? 0 : mesh.uvs[2 * std::size_t(pair) + 1]);
  }
  split.triangles = parts.triangles();
  return split;
}

}  // namespace fb
