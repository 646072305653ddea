#include "solve/sampled_surface.h"

#include <algorithm>
#include <cmath>

namespace fb::tool {

namespace {

float fraction(double value) {
  return static_cast<float>(value - std::floor(value));
}

}  // namespace

SurfaceSamples sample_surface(std::span<const float> points, std::span<const std::uint32_t> triangles,
                              std::size_t count) {
  const auto corner = [&](std::size_t t, std::size_t k) { return vector_at(points.data(), triangles[3 * t + k]); };
  const auto doubled = [&](std::size_t t) { return cross(corner(t, 1) - corner(t, 0), corner(t, 2) - corner(t, 0)); };
  std::vector<double> until(triangles.size() / 3);  // area of all triangles up to this one
  double area = 0;
  for (std::size_t t = 0; t < until.size(); ++t) until[t] = area += length(doubled(t));
  SurfaceSamples samples;
  for (std::size_t i = 0; i < count && area > 0; ++i) {
    const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(count) * area;
    const auto found = std::ranges::upper_bound(until, at);
    const auto t = static_cast<std::size_t>(std::min(found, until.end() - 1) - until.begin());
    // Multiples of powers of 1 / 1.3247..., the plastic number, fill the square evenly.
    float b = fraction(static_cast<double>(i) * 0.7548776662466927),
          c = fraction(static_cast<double>(i) * 0.5698402909980532);
    if (b + c > 1) b = 1 - b, c = 1 - c;
    samples.points.push_back(corner(t, 0) * (1 - b - c) + corner(t, 1) * b + corner(t, 2) * c);
    samples.normals.push_back(normalized(doubled(t)));
  }
  return samples;
}

BoundingBox box_of(std::span<const Vector3> points) {
  BoundingBox box;
  if (!points.empty()) box = {points[0], points[0]};
  for (const Vector3 p : points) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return box;
}

SampledSurface::SampledSurface(const MeshView& mesh, std::size_t count)
    : points(mesh.points.begin(), mesh.points.end()),
      triangles(mesh.triangles()),
      tree(points, triangles),
      border(points, triangles),
      samples(sample_surface(points, triangles, count)),
      box(box_of(samples.points)),
      diagonal(length(box.high - box.low)) {}

}  // namespace fb::tool
