#include "dense/bumps.h"

#include <cmath>

namespace rigs::dense {
namespace {

using sample_face::dot;
using sample_face::Vec3;

constexpr float radius = 1.5f, height = 0.3f;  // centimetres

}  // namespace

Bumps::Bumps(const sample_face::Rig& rig, std::uint32_t count) {
  const std::vector<Vec3>& rest = rig.rest();
  Vec3 middle;
  for (const Vec3& point : rest) middle += point * (1.0f / static_cast<float>(rest.size()));
  for (std::uint32_t b = 0; b < count; ++b) {
    first_.push_back(static_cast<std::uint32_t>(moves_.size()));
    const Vec3 centre = rest[std::uint64_t(b) * rest.size() / count], out = centre - middle;
    const float length = std::sqrt(dot(out, out));
    for (std::uint32_t v = 0; v < rest.size() && length > 0; ++v) {
      const Vec3 offset = rest[v] - centre;
      const float near = 1 - dot(offset, offset) / (radius * radius);
      if (near > 0) moves_.push_back({v, out * (height * near * near / length)});
    }
  }
  if (count > 0) first_.push_back(static_cast<std::uint32_t>(moves_.size()));
}

void Bumps::add(const float* controls, const std::vector<float>& sample, std::vector<Vec3>& points) const {
  for (std::size_t b = 0; b < count(); ++b) {
    if (controls[b] == 0) continue;
    const float other = std::fabs(sample[b % sample.size()]), far = controls[b] * (1 - 0.5f * other);
    for (std::uint32_t m = first_[b]; m < first_[b + 1]; ++m) points[moves_[m].vertex] += moves_[m].by * far;
  }
}

float Bumps::value_in_clip(std::size_t bump, std::size_t frame) const {
  if (bump % 5 != 0) return 0;
  const auto number = static_cast<float>(bump);
  return std::sin((0.03f + 0.01f * std::fmod(number, 7.0f)) * static_cast<float>(frame) + number);
}

}  // namespace rigs::dense
