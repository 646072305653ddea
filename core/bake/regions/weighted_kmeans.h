#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace fb::bake {

struct KmeansOptions {
  std::size_t clusters = 8;          // at most
  std::size_t min_cluster_size = 1;  // points of smaller clusters go to the others
  std::size_t restarts = 6;          // from random centres; the result with the least cost is kept
  std::size_t max_iterations = 40;
  std::uint64_t seed = 1;
};

// Weighted k-means clustering: the cluster of each point, numbered from 0 without gaps. Minimises the sum of weight x
// squared distance to the cluster's weighted mean by Lloyd's iteration from k-means++ starts (Arthur, Vassilvitskii,
// SODA 2007). `points`: one row of `width` floats each; weights are not negative. Deterministic for a seed.
std::vector<std::uint32_t> weighted_kmeans(std::span<const float> points, std::size_t width,
                                           std::span<const double> weights, const KmeansOptions& options);

}  // namespace fb::bake
