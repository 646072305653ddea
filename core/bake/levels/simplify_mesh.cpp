#include "bake/levels/simplify_mesh.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

namespace fb::bake {
namespace {

// A mesh of the character as triangles of wedges: a vertex with a pair of texture coordinates and a material. What lies
// on both sides of a seam are different wedges at one point, which the simplifier collapses together.
struct WedgeMesh {
  std::vector<std::uint32_t> vertex, uv, run;  // by wedge; the material run counts within the mesh
  std::vector<std::uint32_t> triangles;        // wedges
};

// The meshes of the character, or all as one.
std::vector<MeshPart> parts_of(const Mesh& rest) {
  if (!rest.parts.empty()) return rest.parts;
  return {{"", static_cast<std::uint32_t>(rest.surface_vertex_count()),
           static_cast<std::uint32_t>(rest.polygon_sizes.size())}};
}

std::vector<WedgeMesh> wedge_meshes(const Mesh& rest) {
  std::vector<WedgeMesh> meshes;
  std::size_t polygon = 0, corner = 0;
  for (const MeshPart& part : parts_of(rest)) {
    WedgeMesh& mesh = meshes.emplace_back();
    std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, std::uint32_t> wedges;
    std::uint32_t run = 0, left = part.materials.empty() ? part.polygons : part.materials[0].polygons;
    for (std::uint32_t p = 0; p < part.polygons; ++p, --left) {
      if (left == 0) left = part.materials[++run].polygons;
      const std::uint32_t size = rest.polygon_sizes[polygon++];
      std::vector<std::uint32_t> of_corner;
      for (const std::size_t end = corner + size; corner < end; ++corner) {
        const std::uint32_t v = rest.polygon_corners[corner], uv = rest.uvs.empty() ? 0 : rest.uv_corners[corner];
        const auto [wedge, added] = wedges.try_emplace({v, uv, run}, static_cast<std::uint32_t>(wedges.size()));
        if (added) mesh.vertex.push_back(v), mesh.uv.push_back(uv), mesh.run.push_back(run);
        of_corner.push_back(wedge->second);
      }
      for (std::uint32_t k = 1; k + 1 < size; ++k)
        mesh.triangles.insert(mesh.triangles.end(), {of_corner[0], of_corner[k], of_corner[k + 1]});
    }
  }
  return meshes;
}

// The triangles with about `target` corners; as they are if fewer cannot be had.
void simplify(WedgeMesh& mesh, std::span<const float> points, std::size_t target) {
  constexpr float any_error = 1e6f;  // over the size of the mesh: the number of triangles alone counts
  if (mesh.triangles.size() <= target) return;
  std::vector<float> positions;
  for (const std::uint32_t v : mesh.vertex)
    positions.insert(positions.end(), &points[3 * std::size_t(v)], &points[3 * std::size_t(v)] + 3);
  std::vector<unsigned> simplified(mesh.triangles.size());
  simplified.resize(meshopt_simplify(simplified.data(), mesh.triangles.data(), mesh.triangles.size(), positions.data(),
                                     mesh.vertex.size(), 3 * sizeof(float), target, any_error, 0, nullptr));
  if (!simplified.empty()) mesh.triangles.assign(simplified.begin(), simplified.end());
}

void add_to_level(const WedgeMesh& mesh, const MeshPart& part, bool uvs, DetailLevel& level) {
  std::vector<std::uint32_t> order(mesh.triangles.size() / 3);
  std::iota(order.begin(), order.end(), 0u);
  const auto run_of = [&](std::uint32_t t) { return mesh.run[mesh.triangles[3 * std::size_t(t)]]; };
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return run_of(a) < run_of(b); });
  LevelPart made{static_cast<std::uint32_t>(order.size())};
  std::uint32_t last = UINT32_MAX;
  for (const std::uint32_t t : order) {
    level.polygon_sizes.push_back(3);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t wedge = mesh.triangles[3 * std::size_t(t) + k];
      level.polygon_corners.push_back(mesh.vertex[wedge]);
      if (uvs) level.uv_corners.push_back(mesh.uv[wedge]);
    }
    if (part.materials.empty()) continue;
    if (run_of(t) != last) made.materials.push_back({0, part.materials[run_of(t)].material});
    last = run_of(t);
    ++made.materials.back().polygons;
  }
  level.parts.push_back(std::move(made));
}

}  // namespace

void find_coarsest_levels(const Mesh& rest, std::span<const std::uint32_t> kept, LevelPlan& plan) {
  const auto last = static_cast<std::uint8_t>(plan.levels.size());
  plan.coarsest.assign(rest.vertex_count(), 0);
  std::fill_n(plan.coarsest.begin(), rest.surface_vertex_count(), last);
  for (const std::uint32_t v : rest.polygon_corners) plan.coarsest[v] = 0;
  for (std::uint8_t k = 1; k <= last; ++k)
    for (const std::uint32_t v : plan.levels[k - 1u].polygon_corners) plan.coarsest[v] = std::max(plan.coarsest[v], k);
  for (const std::uint32_t v : kept) plan.coarsest[v] = last;
}

LevelPlan simplified_levels(const Mesh& rest, std::span<const float> points, std::span<const double> shares,
                            std::span<const std::uint32_t> kept) {
  LevelPlan plan;
  const std::vector<MeshPart> parts = parts_of(rest);
  std::vector<WedgeMesh> meshes = wedge_meshes(rest);
  std::vector<std::size_t> whole;
  for (const WedgeMesh& mesh : meshes) whole.push_back(mesh.triangles.size() / 3);
  for (const double share : shares) {
    DetailLevel& level = plan.levels.emplace_back();
    for (std::size_t m = 0; m < meshes.size(); ++m) {
      simplify(meshes[m], points, 3 * static_cast<std::size_t>(share * double(whole[m])));
      add_to_level(meshes[m], parts[m], !rest.uvs.empty(), level);
    }
    if (rest.parts.empty()) level.parts.clear();
  }
  find_coarsest_levels(rest, kept, plan);
  return plan;
}

}  // namespace fb::bake
