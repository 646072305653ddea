#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fb::bake {

struct KmeansOptions {
  std::size_t clusters = 8;  // at most
  std::size_t smallest = 1;  // clusters of fewer points are dissolved among the others
  std::size_t restarts = 6;  // the best of as many starts
  std::size_t steps = 40;
  std::uint64_t seed = 1;
};

// The cluster of each point, numbered from 0 without gaps: the least sum of weight x squared distance to the cluster's
// weighted mean that Lloyd's iteration finds from k-means++ starts (Arthur, Vassilvitskii, SODA 2007). `points`: one
// row of `width` floats each; weights are not negative. The same for the same seed.
std::vector<std::uint32_t> weighted_kmeans(std::span<const float> points, std::size_t width,
                                           std::span<const double> weights, const KmeansOptions& options);

}  // namespace fb::bake
