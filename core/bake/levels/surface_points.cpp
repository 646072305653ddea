#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "bake/levels/level_plan.h"
#include "bake/regions/surface_graph.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// A vertex at rest and moved: where the moved surface lies on itself, its rest position tells it apart.
using Point = std::array<double, 6>;

Point minus(Point a, const Point& b) {
  for (std::size_t axis = 0; axis < a.size(); ++axis) a[axis] -= b[axis];
  return a;
}

double dot(const Point& a, const Point& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

// Weights of b and c of the point of triangle a, b, c that is nearest to p (Ericson, Real-Time Collision Detection,
// 2005, 5.1.5, which takes nothing but scalar products: it holds for any number of axes).
std::array<double, 2> surface_weights(const Point& p, const Point& a, const Point& b, const Point& c) {
  const Point ab = minus(b, a), ac = minus(c, a), ap = minus(p, a), bp = minus(p, b), cp = minus(p, c);
  const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
               d6 = dot(ac, cp);
  if (d1 <= 0 && d2 <= 0) return {0, 0};
  if (d3 >= 0 && d4 <= d3) return {1, 0};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {d1 / (d1 - d3), 0};
  if (d6 >= 0 && d5 <= d6) return {0, 1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {0, d2 / (d2 - d6)};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {1 - w, w};
  }
  const double sum = va + vb + vc;
  return {vb / sum, vc / sum};
}

// The triangles of a level around each vertex.
struct LevelTriangles {
  LevelTriangles(const DetailLevel& level, std::size_t vertices)
      : corners(level.triangles()), first(vertices + 1), around(corners.size()) {
    for (const std::uint32_t v : corners) ++first[v + 1];
    for (std::size_t v = 0; v < vertices; ++v) first[v + 1] += first[v];
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t i = 0; i < corners.size(); ++i) around[next[corners[i]]++] = i / 3;
  }
  bool has(std::uint32_t v) const { return first[v] < first[v + 1]; }

  std::vector<std::uint32_t> corners, first, around;
};

class SurfaceSearch {
 public:
  SurfaceSearch(const Mesh& rest, std::span<const float> points)
      : rest_(rest), points_(points), graph_(rest, {}), seen_(rest.vertex_count()) {}

  SurfacePoint nearest(const LevelTriangles& level, std::uint32_t vertex) {
    // Vertices of the level, by the number of edges to them: the corners of a large triangle lie further away than
    // those of many small ones. With 8, vertices of test_plan_levels came to lie five times further off.
    constexpr std::size_t enough = 64;
    queue_.assign(1, vertex);
    seen_[vertex] = ++mark_;
    best_ = INFINITY;
    std::size_t found = 0;
    for (std::size_t next = 0; next < queue_.size() && found < enough; ++next) {
      const std::uint32_t v = queue_[next];
      if (level.has(v)) {
        ++found;
        for (std::uint32_t i = level.first[v]; i < level.first[v + 1]; ++i)
          try_triangle(level, level.around[i], vertex);
      }
      for (const SurfaceGraph::Edge& edge : graph_.edges(v))
        if (seen_[edge.vertex] != mark_) {
          seen_[edge.vertex] = mark_;
          queue_.push_back(edge.vertex);
        }
    }
    if (found == 0) try_mesh(level, vertex);
    return point_;
  }

  bool found() const { return best_ < INFINITY; }

 private:
  Point point_of(std::uint32_t v) const {
    Point point;
    std::copy_n(&rest_.points[3 * std::size_t(v)], 3, point.begin());
    std::copy_n(&points_[3 * std::size_t(v)], 3, point.begin() + 3);
    return point;
  }

  void try_triangle(const LevelTriangles& level, std::uint32_t triangle, std::uint32_t vertex) {
    const std::uint32_t* const corner = &level.corners[3 * std::size_t(triangle)];
    const Point p = point_of(vertex), a = point_of(corner[0]), b = point_of(corner[1]), c = point_of(corner[2]);
    const auto [wb, wc] = surface_weights(p, a, b, c);
    Point away = minus(p, a);
    const Point ab = minus(b, a), ac = minus(c, a);
    for (std::size_t axis = 0; axis < away.size(); ++axis) away[axis] -= wb * ab[axis] + wc * ac[axis];
    const double distance = dot(away, away);
    if (!(distance < best_)) return;
    best_ = distance;
    const auto code = [](double weight) { return std::clamp(std::lround(256 * weight), 0L, 255L); };
    const long first = code(wb), second = std::min(code(wc), 256 - first);
    point_ = {triangle, {static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(second)}};
  }

  // All triangles of the mesh that the vertex belongs to: its own piece of surface has none.
  void try_mesh(const LevelTriangles& level, std::uint32_t vertex) {
    const std::vector<std::uint32_t> ends = rest_.part_ends();
    const auto part = std::upper_bound(ends.begin(), ends.end(), vertex);
    const std::uint32_t begin = part == ends.begin() ? 0 : *(part - 1);
    for (std::uint32_t t = 0; t < level.corners.size() / 3; ++t)
      if (level.corners[3 * std::size_t(t)] >= begin && level.corners[3 * std::size_t(t)] < *part)
        try_triangle(level, t, vertex);
  }

  const Mesh& rest_;
  std::span<const float> points_;
  SurfaceGraph graph_;
  std::vector<std::uint32_t> seen_, queue_;
  std::uint32_t mark_ = 0;
  double best_ = INFINITY;
  SurfacePoint point_;
};

}  // namespace

void find_surface_points(const Mesh& rest, std::span<const float> points, LevelPlan& plan) {
  plan.points.assign(rest.vertex_count(), {});
  SurfaceSearch search(rest, points);
  for (std::size_t k = 1; k <= plan.levels.size(); ++k) {
    const LevelTriangles level(plan.levels[k - 1], rest.vertex_count());
    for (std::uint32_t v = 0; v < rest.surface_vertex_count(); ++v) {
      if (plan.coarsest[v] + 1u != k) continue;
      plan.points[v] = search.nearest(level, v);
      if (!search.found())
        fail(Status::bad_data, "level %zu has no polygons of the mesh that vertex %u belongs to", k, v);
    }
  }
}

}  // namespace fb::bake
