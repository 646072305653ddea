#include "bake/compress/vertex_blocks.h"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <utility>

#include "base/status.h"

namespace fb::bake {
namespace {

std::size_t longest_axis(const Mesh& rest, std::span<const std::uint32_t> vertices) {
  std::array<float, 3> extent{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    float low = rest.points[3 * std::size_t(vertices[0]) + axis], high = low;
    for (const std::uint32_t v : vertices) {
      low = std::min(low, rest.points[3 * std::size_t(v) + axis]);
      high = std::max(high, rest.points[3 * std::size_t(v) + axis]);
    }
    extent[axis] = high - low;
  }
  return std::size_t(std::max_element(extent.begin(), extent.end()) - extent.begin());
}

void bisect(const Mesh& rest, std::span<std::uint32_t> vertices, std::uint32_t largest,
            std::vector<std::vector<std::uint32_t>>& blocks) {
  const std::size_t count = (vertices.size() + largest - 1) / largest;
  if (count <= 1) {
    blocks.emplace_back(vertices.begin(), vertices.end());
    std::sort(blocks.back().begin(), blocks.back().end());
    return;
  }
  const std::size_t axis = longest_axis(rest, vertices), half = vertices.size() * (count / 2) / count;
  std::nth_element(vertices.begin(), vertices.begin() + std::ptrdiff_t(half), vertices.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     return std::pair(rest.points[3 * std::size_t(a) + axis], a) <
                            std::pair(rest.points[3 * std::size_t(b) + axis], b);
                   });
  bisect(rest, vertices.first(half), largest, blocks);
  bisect(rest, vertices.subspan(half), largest, blocks);
}

}  // namespace

std::vector<std::vector<std::uint32_t>> vertex_blocks(const Mesh& rest, std::span<const std::uint32_t> labels,
                                                      std::uint32_t largest,
                                                      std::span<const std::uint8_t> coarsest_levels) {
  if (labels.size() != rest.vertex_count() || largest == 0 ||
      (!coarsest_levels.empty() && coarsest_levels.size() != labels.size()))
    fail(Status::invalid_argument, "blocks of at most %u vertices, %zu labels for %zu vertices", largest, labels.size(),
         rest.vertex_count());
  // By level, the coarsest first, part and label.
  std::map<std::tuple<int, std::size_t, std::uint32_t>, std::vector<std::uint32_t>> of_label;
  const std::vector<std::uint32_t> ends = rest.part_ends();
  for (std::size_t v = 0, part = 0; v < labels.size(); ++v) {
    while (v >= ends[part]) ++part;
    const std::uint32_t label = v < rest.surface_vertex_count() ? labels[v] : 0;
    of_label[{coarsest_levels.empty() ? 0 : -coarsest_levels[v], part, label}].push_back(std::uint32_t(v));
  }
  std::vector<std::vector<std::uint32_t>> blocks;
  for (auto& [label, vertices] : of_label) bisect(rest, vertices, largest, blocks);
  return blocks;
}

}  // namespace fb::bake
