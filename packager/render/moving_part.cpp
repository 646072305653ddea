#include "render/moving_part.h"

#include <algorithm>
#include <cmath>

namespace fb::tool {
namespace {

constexpr double moving = 2e-3, part_of_mesh = 0.35;  // of the diagonal

}  // namespace

MovingPart::MovingPart(const MeshView& rest)
    : rest_(rest.points),
      diagonal_(rest.diagonal()),
      box_{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}} {}

void MovingPart::add(std::span<const float> points) {
  const double still = moving * diagonal_;
  for (std::size_t v = 0; v < rest_.size() / 3; ++v) {
    const Vector3 p = vector_at(rest_.data(), v), distance = vector_at(points.data(), v) - p;
    if (dot(distance, distance) <= still * still) continue;
    box_.low = {std::min(box_.low.x, p.x), std::min(box_.low.y, p.y), std::min(box_.low.z, p.z)};
    box_.high = {std::max(box_.high.x, p.x), std::max(box_.high.y, p.y), std::max(box_.high.z, p.z)};
  }
}

std::optional<BoundingBox> MovingPart::region() const {
  const Vector3 size = box_.high - box_.low;
  if (!(box_.low.x <= box_.high.x) || length(size) >= part_of_mesh * diagonal_) return std::nullopt;
  return BoundingBox{box_.low - size * 0.5f, box_.high + size * 0.5f};
}

}  // namespace fb::tool
