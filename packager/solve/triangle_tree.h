// Closest points on a surface.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "base/vector3.h"
#include "solve/surface_point.h"

namespace fb::tool {

struct ClosestPoint {
  std::uint32_t triangle = 0;
  SurfacePoint surface;
  Vector3 position;
  float distance = 0;
};

// Which points of the surface count.
struct ClosestQuery {
  float most_distance = std::numeric_limits<float>::infinity();
  // Triangles whose normal has at least this cosine to the unit vector `normal`; none: all triangles.
  std::optional<Vector3> normal{};
  float least_cosine = 0.5f;
};

// A tree of boxes over triangles, cut at medians. Immutable: any threads may ask at once. Results do not depend on the
// order of questions.
class TriangleTree {
 public:
  // triangles: three vertex indices each; points: 3 x vertices. Both are copied. Triangles without area are left out.
  // Fails with bad_data if none is left, or a point or an index is none.
  TriangleTree(std::span<const float> points, std::span<const std::uint32_t> triangles);

  // Nothing where no triangle counts.
  std::optional<ClosestPoint> closest(Vector3 point, const ClosestQuery& query = {}) const;
  // Unit normal of a triangle of the constructor's.
  Vector3 normal(std::uint32_t triangle) const { return normals_[triangle]; }

 private:
  struct Node {
    Vector3 low, high;
    std::uint32_t first = 0, count = 0;  // of order_; count 0: the children are the next node and `second`
    std::uint32_t second = 0;
  };
  std::uint32_t add_node(std::uint32_t first, std::uint32_t count, std::span<const Vector3> centres);
  void visit_leaf(const Node& node, Vector3 point, const ClosestQuery& query, std::optional<ClosestPoint>& best) const;

  std::vector<float> points_;
  std::vector<std::uint32_t> triangles_, order_;
  std::vector<Vector3> normals_;
  std::vector<Node> nodes_;
};

}  // namespace fb::tool
