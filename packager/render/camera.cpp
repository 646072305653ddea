#include "render/camera.h"

#include <algorithm>
#include <cmath>

namespace fb::tool {
namespace {

bool inside(const BoundingBox& box, Vector3 p) {
  return p.x >= box.low.x && p.x <= box.high.x && p.y >= box.low.y && p.y <= box.high.y && p.z >= box.low.z &&
         p.z <= box.high.z;
}

struct Extent {
  float low = INFINITY, high = -INFINITY;
  void include(float value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  float middle() const { return 0.5f * (low + high); }
};

}  // namespace

Vector3 Camera::to_camera(Vector3 point) const {
  const Vector3 d = point - position;
  return {dot(d, right), dot(d, up), dot(d, back)};
}

std::array<float, 2> Camera::project(Vector3 point) const {
  const Vector3 e = to_camera(point);
  return {0.5f - 0.5f * e.x / e.z * focal / aspect, 0.5f + 0.5f * e.y / e.z * focal};
}

Camera fit_camera(std::span<const float> points, std::string_view up_axis, const View& view, float aspect) {
  constexpr float radians = 3.14159265f / 180;
  const bool z_up = up_axis == "z";
  const Vector3 world_up = z_up ? Vector3{0, 0, 1} : Vector3{0, 1, 0};
  const Vector3 front = z_up ? Vector3{0, -1, 0} : Vector3{0, 0, 1};
  const Vector3 side = cross(world_up, front);

  Camera camera;
  const float yaw = view.yaw * radians, pitch = view.pitch * radians;
  camera.back = (front * std::cos(yaw) + side * std::sin(yaw)) * std::cos(pitch) + world_up * std::sin(pitch);
  camera.right = side * std::cos(yaw) - front * std::sin(yaw);
  camera.up = cross(camera.back, camera.right);
  camera.aspect = aspect;
  camera.focal = 1 / std::tan(0.5f * view.field_of_view * radians);

  const auto in_region = [&](std::size_t vertex) {
    return !view.region || inside(*view.region, vector_at(points.data(), vertex));
  };
  const std::size_t vertices = points.size() / 3;
  Extent x, y, z;
  for (std::size_t v = 0; v < vertices; ++v) {
    if (!in_region(v)) continue;
    const Vector3 p = camera.to_camera(vector_at(points.data(), v));
    x.include(p.x);
    y.include(p.y);
    z.include(p.z);
  }
  if (!(x.low <= x.high)) x = y = z = {-1, 1};
  // A point is in the image when focal * |y| <= (distance - z) * usable, and the same for x / aspect.
  const float usable = 1 - 2 * view.margin;
  const float size = std::max({x.high - x.low, y.high - y.low, z.high - z.low, 1e-20f});
  float distance = z.high + 0.05f * size;
  for (std::size_t v = 0; v < vertices; ++v) {
    if (!in_region(v)) continue;
    const Vector3 p = camera.to_camera(vector_at(points.data(), v));
    const float reach = std::max(std::fabs(p.y - y.middle()), std::fabs(p.x - x.middle()) / aspect);
    distance = std::max(distance, p.z + reach * camera.focal / usable);
  }
  camera.position = camera.right * x.middle() + camera.up * y.middle() + camera.back * distance;
  return camera;
}

}  // namespace fb::tool
