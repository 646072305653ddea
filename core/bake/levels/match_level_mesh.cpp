#include "bake/levels/match_level_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

#include "bake/levels/simplify_mesh.h"
#include "base/hash.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr double tolerance_share = 1e-4;  // of the diagonal

// A vertex with one of the pairs of texture coordinates that it has.
struct Wedge {
  std::uint32_t vertex = 0, uv = 0;
};

// Finds wedges of the rest mesh at a place.
class WedgeFinder {
 public:
  explicit WedgeFinder(const Mesh& rest) : rest_(rest), tolerance_(tolerance_share * rest.diagonal()) {
    std::vector<std::vector<std::uint32_t>> uvs(rest.vertex_count());
    for (std::size_t c = 0; c < rest.polygon_corners.size(); ++c)
      uvs[rest.polygon_corners[c]].push_back(rest.uvs.empty() ? 0 : rest.uv_corners[c]);
    for (std::uint32_t v = 0; v < uvs.size(); ++v) {
      std::sort(uvs[v].begin(), uvs[v].end());
      uvs[v].erase(std::unique(uvs[v].begin(), uvs[v].end()), uvs[v].end());
      for (const std::uint32_t uv : uvs[v]) cells_[cell_of(&rest.points[3 * std::size_t(v)], {})].push_back({v, uv});
    }
  }

  // uv: two numbers; null: any. Returns null if there is none.
  const Wedge* find(const float* point, const float* uv) const {
    const Wedge* best = nullptr;
    double nearest = INFINITY;
    for (int cell = 0; cell < 27; ++cell) {
      const auto wedges = cells_.find(cell_of(point, {cell % 3 - 1, cell / 3 % 3 - 1, cell / 9 - 1}));
      if (wedges == cells_.end()) continue;
      for (const Wedge& wedge : wedges->second) {
        if (distance(point, &rest_.points[3 * std::size_t(wedge.vertex)], 3) > tolerance_) continue;
        const double away = uv && !rest_.uvs.empty() ? distance(uv, &rest_.uvs[2 * std::size_t(wedge.uv)], 2) : 0;
        if (away < nearest || (away == nearest && wedge.vertex < best->vertex)) best = &wedge, nearest = away;
      }
    }
    return best;
  }

 private:
  static double distance(const float* a, const float* b, std::size_t count) {
    double squares = 0;
    for (std::size_t i = 0; i < count; ++i) squares += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
    return std::sqrt(squares);
  }
  std::array<std::int64_t, 3> cell_of(const float* point, const std::array<int, 3>& beside) const {
    std::array<std::int64_t, 3> cell{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      cell[axis] = static_cast<std::int64_t>(std::floor(double(point[axis]) / tolerance_)) + beside[axis];
    return cell;
  }

  const Mesh& rest_;
  double tolerance_;
  std::map<std::array<std::int64_t, 3>, std::vector<Wedge>> cells_;
};

// Which mesh of the character a vertex belongs to, and which material runs its polygons have.
struct VertexParts {
  explicit VertexParts(const Mesh& rest) : runs(rest.vertex_count()) {
    const std::vector<std::uint32_t> ends = rest.part_ends();
    for (std::uint32_t part = 0; part < ends.size(); ++part) of.resize(ends[part], part);
    std::size_t polygon = 0, corner = 0;
    for (const MeshPart& part : rest.parts)
      for (std::uint32_t run = 0; run < part.materials.size(); ++run)
        for (std::uint32_t p = 0; p < part.materials[run].polygons; ++p)
          for (const std::size_t end = corner + rest.polygon_sizes[polygon++]; corner < end; ++corner) {
            std::vector<std::uint32_t>& here = runs[rest.polygon_corners[corner]];
            if (here.empty() || here.back() != run) here.push_back(run);
          }
  }
  // The run that most of these vertices have a polygon of; the first of several.
  std::uint32_t run_of(std::span<const Wedge> corners) const {
    std::map<std::uint32_t, std::size_t> counts;
    for (const Wedge& corner : corners)
      for (const std::uint32_t run : runs[corner.vertex]) ++counts[run];
    std::uint32_t best = 0;
    std::size_t most = 0;
    for (const auto& [run, count] : counts)
      if (count > most) best = run, most = count;
    return best;
  }

  std::vector<std::uint32_t> of;
  std::vector<std::vector<std::uint32_t>> runs;
};

struct MatchedPolygon {
  std::uint32_t part, run;
  std::vector<Wedge> corners;
};

std::vector<MatchedPolygon> matched_polygons(const LevelMesh& given, const WedgeFinder& finder,
                                             const VertexParts& parts) {
  const Mesh& mesh = given.mesh;
  std::vector<MatchedPolygon> polygons;
  std::size_t corner = 0;
  for (const std::uint32_t size : mesh.polygon_sizes) {
    MatchedPolygon& polygon = polygons.emplace_back();
    for (const std::size_t end = corner + size; corner < end; ++corner) {
      const std::uint32_t v = mesh.polygon_corners[corner];
      const float *const point = &mesh.points[3 * std::size_t(v)],
                         *const uv = mesh.uvs.empty() ? nullptr : &mesh.uvs[2 * std::size_t(mesh.uv_corners[corner])];
      const Wedge* const found = finder.find(point, uv);
      if (!found)
        fail(Status::bad_data,
             "%s: vertex %u at (%g, %g, %g) is no vertex of the character: none lies within %g of the diagonal",
             given.name.c_str(), v, double(point[0]), double(point[1]), double(point[2]), tolerance_share);
      polygon.corners.push_back(*found);
      if (parts.of[found->vertex] != parts.of[polygon.corners[0].vertex])
        fail(Status::bad_data, "%s: polygon %zu has vertices of two meshes of the character", given.name.c_str(),
             polygons.size() - 1);
    }
    polygon.part = parts.of[polygon.corners[0].vertex];
    polygon.run = parts.run_of(polygon.corners);
  }
  std::stable_sort(polygons.begin(), polygons.end(), [](const MatchedPolygon& a, const MatchedPolygon& b) {
    return std::pair(a.part, a.run) < std::pair(b.part, b.run);
  });
  return polygons;
}

}  // namespace

LevelPlan matched_levels(const Mesh& rest, std::span<const LevelMesh> meshes, std::span<const std::uint32_t> kept) {
  const WedgeFinder finder(rest);
  const VertexParts parts(rest);
  LevelPlan plan;
  for (const LevelMesh& given : meshes) {
    DetailLevel& level = plan.levels.emplace_back();
    level.parts.resize(rest.parts.size());
    std::uint32_t last_run = UINT32_MAX, last_part = UINT32_MAX;
    for (const MatchedPolygon& polygon : matched_polygons(given, finder, parts)) {
      level.polygon_sizes.push_back(static_cast<std::uint32_t>(polygon.corners.size()));
      for (const Wedge& corner : polygon.corners) {
        level.polygon_corners.push_back(corner.vertex);
        if (!rest.uvs.empty()) level.uv_corners.push_back(corner.uv);
      }
      if (rest.parts.empty()) continue;
      LevelPart& part = level.parts[polygon.part];
      ++part.polygons;
      const std::vector<MaterialRun>& runs = rest.parts[polygon.part].materials;
      if (runs.empty()) continue;
      if (polygon.run != last_run || polygon.part != last_part)
        part.materials.push_back({0, runs[polygon.run].material});
      last_run = polygon.run;
      last_part = polygon.part;
      ++part.materials.back().polygons;
    }
  }
  find_coarsest_levels(rest, kept, plan);
  return plan;
}

}  // namespace fb::bake
