#include "bake/compress/vertex_spacing.h"

#include <algorithm>
#include <cmath>

#include "base/vector3.h"

namespace fb::bake {

std::vector<float> vertex_spacing(const Mesh& rest) {
  const std::vector<std::uint32_t> triangles = rest.triangles();
  std::vector<float> spacing(rest.vertex_count());
  for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
    const auto corner = [&](std::size_t k) { return vector_at(rest.points.data(), triangles[t + k]); };
    const float area = length(cross(corner(1) - corner(0), corner(2) - corner(0)));
    for (std::size_t k = 0; k < 3; ++k) spacing[triangles[t + k]] += area;
  }
  std::vector<float> positive;
  for (float& value : spacing) {
    value = std::sqrt(value);
    if (value > 0) positive.push_back(value);
  }
  if (positive.empty()) return std::vector<float>(spacing.size(), 1.0f);
  const auto middle = positive.begin() + static_cast<std::ptrdiff_t>(positive.size() / 2);
  std::nth_element(positive.begin(), middle, positive.end());
  for (float& value : spacing) value = value > 0 ? value / *middle : 1;
  return spacing;
}

}  // namespace fb::bake
