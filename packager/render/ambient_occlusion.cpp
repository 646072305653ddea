#include "render/ambient_occlusion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fb::tool {
namespace {

// More of either makes shadows smoother and rendering slower.
constexpr int direction_count = 64;
constexpr int depth_map_size = 256;  // pixels

// Evenly spread over the sphere: a golden-angle spiral.
Vector3 direction(int index) {
  const float y = 1 - 2 * (index + 0.5f) / direction_count, radius = std::sqrt(1 - y * y);
  const float angle = 2.39996323f * index;
  return {radius * std::cos(angle), y, radius * std::sin(angle)};
}

struct Sphere {
  Vector3 centre;
  float radius = 0;
};

// Around the bounding box of the points.
Sphere bounding_sphere(std::span<const float> points) {
  const float infinity = std::numeric_limits<float>::infinity();
  Vector3 low = {infinity, infinity, infinity}, high = low * -1.0f;
  for (std::size_t v = 0; v < points.size() / 3; ++v) {
    const Vector3 p = vector_at(points.data(), v);
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  return {(low + high) * 0.5f, 0.5f * length(high - low)};
}

// Orthographic depth map of the mesh, seen from one direction.
class DepthMap {
 public:
  DepthMap(std::span<const std::uint32_t> triangles, std::span<const float> points, const Sphere& bounds,
           Vector3 towards)
      : towards_(towards),
        bounds_(bounds),
        heights_(depth_map_size * depth_map_size, -std::numeric_limits<float>::infinity()) {
    const Vector3 helper = std::fabs(towards.y) < 0.9f ? Vector3{0, 1, 0} : Vector3{1, 0, 0};
    right_ = normalized(cross(helper, towards));
    up_ = cross(towards, right_);
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3)
      rasterize(project(vector_at(points.data(), triangles[t])), project(vector_at(points.data(), triangles[t + 1])),
                project(vector_at(points.data(), triangles[t + 2])));
  }

  bool occludes(Vector3 point) const {
    const Vector3 p = project(point);
    const int x = std::clamp(static_cast<int>(p.x), 0, depth_map_size - 1),
              y = std::clamp(static_cast<int>(p.y), 0, depth_map_size - 1);
    return heights_[y * depth_map_size + x] > p.z;
  }

 private:
  // x and y in pixels, z towards the viewer in the unit of the points.
  Vector3 project(Vector3 point) const {
    const Vector3 d = point - bounds_.centre;
    const float scale = 0.5f * depth_map_size / bounds_.radius;
    return {(dot(d, right_)) * scale + 0.5f * depth_map_size, dot(d, up_) * scale + 0.5f * depth_map_size,
            dot(d, towards_)};
  }

  void rasterize(Vector3 a, Vector3 b, Vector3 c) {
    const float twice_area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (!(std::fabs(twice_area) > 1e-6f)) return;
    const auto pixel = [](float value) { return std::clamp(static_cast<int>(value), 0, depth_map_size - 1); };
    for (int y = pixel(std::min({a.y, b.y, c.y})); y <= pixel(std::max({a.y, b.y, c.y})); ++y)
      for (int x = pixel(std::min({a.x, b.x, c.x})); x <= pixel(std::max({a.x, b.x, c.x})); ++x) {
        const float px = x + 0.5f - a.x, py = y + 0.5f - a.y;
        const float wb = (px * (c.y - a.y) - (c.x - a.x) * py) / twice_area;
        const float wc = ((b.x - a.x) * py - px * (b.y - a.y)) / twice_area;
        if (wb < 0 || wc < 0 || wb + wc > 1) continue;
        float& height = heights_[y * depth_map_size + x];
        height = std::max(height, a.z + wb * (b.z - a.z) + wc * (c.z - a.z));
      }
  }

  Vector3 right_, up_, towards_;
  const Sphere& bounds_;
  std::vector<float> heights_;  // of the surface nearest to the viewer, a pixel each
};

}  // namespace

std::vector<float> vertex_ambient_occlusion(std::span<const std::uint32_t> triangles, std::span<const float> points,
                                            std::span<const Vector3> normals, const Parallel& parallel) {
  // One depth map a direction gives the vertices lit from there; directions are summed in order, so that the result
  // does not depend on threads.
  const std::size_t vertices = normals.size();
  const Sphere bounds = bounding_sphere(points);
  if (!(bounds.radius > 0)) return std::vector<float>(vertices, 1.0f);
  const float bias = 4 * bounds.radius / depth_map_size;  // off the surface, so that it does not occlude itself
  std::vector<Vector3> directions;
  for (int d = 0; d < direction_count; ++d) directions.push_back(direction(d));
  std::vector<std::vector<float>> light(direction_count, std::vector<float>(vertices));
  parallel_for(parallel, direction_count, [&](std::size_t index, std::size_t) {
    const Vector3 towards = directions[index];
    const DepthMap map(triangles, points, bounds, towards);
    for (std::size_t v = 0; v < vertices; ++v) {
      const float cosine = dot(normals[v], towards);
      if (cosine > 0 && !map.occludes(vector_at(points.data(), v) + normals[v] * bias)) light[index][v] = cosine;
    }
  });
  std::vector<float> reached_share(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    float reached = 0, hemisphere = 0;
    for (int d = 0; d < direction_count; ++d) {
      reached += light[d][v];
      hemisphere += std::max(0.0f, dot(normals[v], directions[d]));
    }
    reached_share[v] = hemisphere > 0 ? reached / hemisphere : 1.0f;
  }
  return reached_share;
}

}  // namespace fb::tool
