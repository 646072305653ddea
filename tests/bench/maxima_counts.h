// The worst vertex of each frame, and what is told of many frames.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

namespace fb::bench {

// Largest distances of a vertex in each frame, over the diagonal.
class MaximaCounts {
 public:
  void add(double distance) { maxima_.push_back(distance); }
  void append(const MaximaCounts& more) { maxima_.insert(maxima_.end(), more.maxima_.begin(), more.maxima_.end()); }

  // A line of the largest, mean and 99th percentile of the frames' maxima, and how many frames lie above 1e-3, 3e-3 and
  // 1e-2.
  void print(double diagonal, const std::string& units) const {
    if (maxima_.empty()) {
      std::printf("no frames\n");
      return;
    }
    std::vector<double> sorted = maxima_;
    std::ranges::sort(sorted);
    double sum = 0;
    for (const double value : sorted) sum += value;
    const double mean = sum / static_cast<double>(sorted.size());
    std::printf(
        "max %.3g %s, %.2e  mean of maxima %.3g %s, %.2e  p99 %.2e  above 1e-3, 3e-3, 1e-2: %zu, %zu, %zu of %zu\n",
        sorted.back() * diagonal, units.c_str(), sorted.back(), mean * diagonal, units.c_str(), mean,
        sorted[(sorted.size() - 1) * 99 / 100], above(1e-3), above(3e-3), above(1e-2), sorted.size());
    std::fflush(stdout);
  }

 private:
  std::size_t above(double limit) const {
    return static_cast<std::size_t>(std::ranges::count_if(maxima_, [&](double value) { return value > limit; }));
  }

  std::vector<double> maxima_;
};

}  // namespace fb::bench
