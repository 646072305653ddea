#pragma once

#include <cstdio>
#include <string>

#include "bake/measure/frame_maxima.h"

namespace fb::bench {

// A line of the largest, mean and 99th percentile of frame maxima over the diagonal, and how many frames lie above
// 1e-3, 3e-3 and 1e-2.
inline void print_maxima(const bake::FrameMaxima& maxima, double diagonal, const std::string& units) {
  const double max = maxima.max(), mean = maxima.mean();
  std::printf(
      "max %.3g %s, %.2e  mean of maxima %.3g %s, %.2e  p99 %.2e  above 1e-3, 3e-3, 1e-2: %zu, %zu, %zu of %zu\n",
      max * diagonal, units.c_str(), max, mean * diagonal, units.c_str(), mean, maxima.p99(), maxima.above(1e-3),
      maxima.above(3e-3), maxima.above(1e-2), maxima.frames());
  std::fflush(stdout);
}

}  // namespace fb::bench
