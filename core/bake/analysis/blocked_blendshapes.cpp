#include "bake/analysis/blocked_blendshapes.h"

#include <algorithm>
#include <numeric>

#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::size_t block_size = SixteenFloats::count, group_poses = SixteenFloats::count;

// Calls visit(block, first, last) for the shape's coordinates, 3 a vertex, of each block that it moves.
template <class Visit>
void for_blocks_of(const SparseShape& shape, const Visit& visit) {
  const auto block_of = [&](std::size_t i) { return (std::size_t{3} * shape.vertices[i / 3] + i % 3) / block_size; };
  for (std::size_t first = 0; first < shape.offsets.size();) {
    const std::size_t block = block_of(first);
    std::size_t last = first + 1;
    while (last < shape.offsets.size() && block_of(last) == block) ++last;
    visit(block, first, last);
    first = last;
  }
}

}  // namespace

BlockedBlendshapes::BlockedBlendshapes(const SparseBlendshapes& shapes, std::size_t vertices)
    : size_(3 * vertices), features_(shapes.features), first_((size_ + block_size - 1) / block_size + 1) {
  for (const SparseShape& shape : shapes.shapes)
    for_blocks_of(shape, [&](std::size_t block, std::size_t, std::size_t) { ++first_[block + 1]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  term_features_.resize(first_.back());
  offsets_.resize(first_.back());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (const SparseShape& shape : shapes.shapes)
    for_blocks_of(shape, [&](std::size_t block, std::size_t first, std::size_t last) {
      const std::size_t term = next[block]++;
      term_features_[term] = shape.feature;
      float* const offsets = offsets_[term].values;
      for (std::size_t i = first; i < last; ++i)
        offsets[(std::size_t{3} * shape.vertices[i / 3] + i % 3) % block_size] = shape.offsets[i];
    });
}

BlockedBlendshapes::Values BlockedBlendshapes::evaluate(std::span<const float> controls, std::span<const float> rest,
                                                        std::size_t count) const {
  Values group{std::vector<SixteenFloats>(features_.size()), std::vector<std::uint8_t>(features_.size())};
  std::vector<float> values(features_.size());
  for (std::size_t i = 0; i < count; ++i) {
    evaluate_features(features_, controls.subspan(i * rest.size(), rest.size()), rest, values);
    for (std::size_t f = 0; f < values.size(); ++f) {
      group.values[f].values[i] = values[f];
      group.active[f] |= values[f] != 0;
    }
  }
  return group;
}

void BlockedBlendshapes::add(std::span<const float> controls, std::span<const float> rest, std::size_t count,
                             float sign, std::span<float> displacements) const {
  if (controls.size() != count * rest.size() || displacements.size() != count * size_)
    fail(Status::invalid_argument, "%zu poses of %zu controls need %zu values, not %zu, and %zu coordinates, not %zu",
         count, rest.size(), count * rest.size(), controls.size(), count * size_, displacements.size());
  std::vector<Values> groups;
  for (std::size_t first = 0; first < count; first += group_poses) {
    const std::size_t poses = std::min(group_poses, count - first);
    groups.push_back(evaluate(controls.subspan(first * rest.size(), poses * rest.size()), rest, poses));
  }
  std::vector<std::uint32_t> active(features_.size());  // at least as many as shapes
  for (std::size_t block = 0; block + 1 < first_.size(); ++block) {
    const std::uint32_t* const features = term_features_.data() + first_[block];
    const std::size_t terms = first_[block + 1] - first_[block], start = block * block_size;
    for (std::size_t g = 0; g < groups.size(); ++g) {
      std::size_t found = 0;
      for (std::size_t t = 0; t < terms; ++t) {
        active[found] = static_cast<std::uint32_t>(t);
        found += groups[g].active[features[t]];
      }
      if (found == 0) continue;
      SixteenFloats sums[group_poses];
      kernels().add_up_block(found, active.data(), features, offsets_.data() + first_[block], groups[g].values.data(),
                             sums);
      const std::size_t poses = std::min(group_poses, count - g * group_poses);
      for (std::size_t i = 0; i < poses; ++i) {
        float* const to = displacements.data() + (g * group_poses + i) * size_ + start;
        for (std::size_t k = 0; k < std::min(block_size, size_ - start); ++k) to[k] += sign * sums[i].values[k];
      }
    }
  }
}

}  // namespace fb::bake
