// Where a surface ends.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solve/triangle_tree.h"

namespace fb::tool {

// Edges of one triangle alone, where vertices at one place count as one: seams of texture coordinates are no border.
// Such edges of a closed surface do not exist.
class OpenBorder {
 public:
  // triangles: three vertex indices each, of 3 x vertices points.
  OpenBorder(std::span<const float> points, std::span<const std::uint32_t> triangles);

  // Whether a point, found in a tree of the same triangles, lies on the border, or within a hundredth of its triangle's
  // height of it. What lies beyond the border has its closest point there.
  bool has(const ClosestPoint& point) const;
  // Whether there is a border at all.
  bool any() const { return any_; }

 private:
  std::vector<std::uint8_t> edges_;     // of each triangle, bits 0 to 2: the edge opposite of that corner
  std::vector<std::uint8_t> vertices_;  // 1: of a border's edge
  bool any_ = false;
};

}  // namespace fb::tool
