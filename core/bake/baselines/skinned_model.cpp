#include "bake/baselines/skinned_model.h"

#include <algorithm>
#include <numeric>

#include "base/checked.h"

namespace fb::bake {

Basis basis_by_bone(const Skeleton& skeleton, const std::vector<float>& columns) {
  const std::size_t vertices = skeleton.bones.size(), rows = 3 * vertices, count = columns.size() / rows;
  std::vector<std::uint32_t> order(vertices);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return skeleton.bones[a][0] < skeleton.bones[b][0]; });
  std::vector<float> sorted(columns.size());
  for (std::size_t c = 0; c < count; ++c)
    for (std::size_t i = 0; i < vertices; ++i)
      std::copy_n(columns.data() + c * rows + 3 * std::size_t(order[i]), 3, sorted.data() + c * rows + 3 * i);
  Basis basis = make_basis(checked_u32(rows, "coordinates"), checked_u32(count, "columns"), sorted);
  basis.order = std::move(order);
  return basis;
}

}  // namespace fb::bake
