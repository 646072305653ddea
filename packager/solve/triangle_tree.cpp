#include "solve/triangle_tree.h"

#include <algorithm>
#include <cmath>

#include "base/status.h"
#include "base/surface.h"

namespace fb::tool {
namespace {

constexpr std::uint32_t leaf_triangles = 4;

float coordinate(Vector3 p, int axis) {
  return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

float squared_distance(Vector3 point, Vector3 low, Vector3 high) {
  const Vector3 outside = {std::max({low.x - point.x, 0.0f, point.x - high.x}),
                           std::max({low.y - point.y, 0.0f, point.y - high.y}),
                           std::max({low.z - point.z, 0.0f, point.z - high.z})};
  return dot(outside, outside);
}

}  // namespace

TriangleTree::TriangleTree(std::span<const float> points, std::span<const std::uint32_t> triangles)
    : points_(points.begin(), points.end()),
      triangles_(triangles.begin(), triangles.end()),
      normals_(triangles.size() / 3) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!std::isfinite(points[i])) fail(Status::bad_data, "vertex %zu of the mesh has no position", i / 3);
  std::vector<Vector3> centres(triangles.size() / 3);
  for (std::uint32_t t = 0; t < centres.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k)
      if (triangles[3 * t + k] >= points.size() / 3)
        fail(Status::bad_data, "triangle %u of the mesh has a vertex %u, of %zu", t, triangles[3 * t + k],
             points.size() / 3);
    const Vector3 a = vector_at(points.data(), triangles[3 * t]), b = vector_at(points.data(), triangles[3 * t + 1]),
                  c = vector_at(points.data(), triangles[3 * t + 2]);
    normals_[t] = normalized(cross(b - a, c - a));
    centres[t] = (a + b + c) * (1.0f / 3);
    if (length(normals_[t]) > 0.5f) order_.push_back(t);
  }
  if (order_.empty()) fail(Status::bad_data, "the mesh has no surface: no triangle has an area");
  add_node(0, static_cast<std::uint32_t>(order_.size()), centres);
}

// Recursion is as deep as the logarithm of the number of triangles.
std::uint32_t TriangleTree::add_node(std::uint32_t first, std::uint32_t count, std::span<const Vector3> centres) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  Node node{vector_at(points_.data(), triangles_[3 * order_[first]]), {}, first, count};
  node.high = node.low;
  Vector3 low = centres[order_[first]], high = low;
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 p = vector_at(points_.data(), triangles_[3 * order_[i] + k]);
      node.low = {std::min(node.low.x, p.x), std::min(node.low.y, p.y), std::min(node.low.z, p.z)};
      node.high = {std::max(node.high.x, p.x), std::max(node.high.y, p.y), std::max(node.high.z, p.z)};
    }
    const Vector3 c = centres[order_[i]];
    low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
    high = {std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
  }
  nodes_.push_back(node);
  if (count <= leaf_triangles) return index;
  const Vector3 size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::uint32_t half = count / 2;
  std::nth_element(order_.begin() + first, order_.begin() + first + half, order_.begin() + first + count,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const float left = coordinate(centres[a], axis), right = coordinate(centres[b], axis);
                     return left != right ? left < right : a < b;
                   });
  add_node(first, half, centres);
  const std::uint32_t second = add_node(first + half, count - half, centres);
  nodes_[index].second = second;
  nodes_[index].count = 0;
  return index;
}

void TriangleTree::visit_leaf(const Node& node, Vector3 point, const ClosestQuery& query,
                              std::optional<ClosestPoint>& best) const {
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
    const std::uint32_t t = order_[i];
    if (query.normal && dot(*query.normal, normals_[t]) < query.least_cosine) continue;
    ClosestPoint found;
    found.triangle = t;
    std::copy_n(&triangles_[3 * t], 3, found.surface.vertices.begin());
    found.surface.weights = nearest_weights(point, vector_at(points_.data(), triangles_[3 * t]),
                                            vector_at(points_.data(), triangles_[3 * t + 1]),
                                            vector_at(points_.data(), triangles_[3 * t + 2]));
    found.position = found.surface.at(points_);
    found.distance = length(found.position - point);
    if (!(found.distance <= query.most_distance)) continue;
    if (!best || found.distance < best->distance || (found.distance == best->distance && t < best->triangle))
      best = found;
  }
}

std::optional<ClosestPoint> TriangleTree::closest(Vector3 point, const ClosestQuery& query) const {
  struct Waiting {
    std::uint32_t node;
    float squared;
  };
  constexpr std::size_t deepest = 64;  // 2^32 triangles have 31 levels, each of which leaves one node waiting
  std::array<Waiting, deepest> waiting;
  std::size_t count = 0;
  std::optional<ClosestPoint> best;
  waiting[count++] = {0, squared_distance(point, nodes_[0].low, nodes_[0].high)};
  while (count > 0) {
    const Waiting next = waiting[--count];
    const float limit = best ? best->distance : query.most_distance;
    if (next.squared > limit * limit * 1.00001f) continue;  // rounding must not hide an equal distance
    const Node& node = nodes_[next.node];
    if (node.count > 0) {
      visit_leaf(node, point, query, best);
      continue;
    }
    Waiting near = {next.node + 1, 0}, far = {node.second, 0};
    near.squared = squared_distance(point, nodes_[near.node].low, nodes_[near.node].high);
    far.squared = squared_distance(point, nodes_[far.node].low, nodes_[far.node].high);
    if (far.squared < near.squared) std::swap(near, far);
    waiting[count++] = far;
    waiting[count++] = near;
  }
  return best;
}

}  // namespace fb::tool
