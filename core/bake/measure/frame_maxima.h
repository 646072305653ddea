#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace fb::bake {

// The distance of the worst vertex of each frame. Parts are joined with `append`, like ErrorSums.
class FrameMaxima {
 public:
  void add(double squared_distance) { distances_.push_back(static_cast<float>(std::sqrt(squared_distance))); }
  void append(const FrameMaxima& later) {
    distances_.insert(distances_.end(), later.distances_.begin(), later.distances_.end());
  }

  std::size_t frames() const { return distances_.size(); }
  std::size_t above(double distance) const {
    return static_cast<std::size_t>(
        std::count_if(distances_.begin(), distances_.end(), [&](float value) { return value > distance; }));
  }

  // Of no frames: 0.
  double max() const { return distances_.empty() ? 0 : *std::max_element(distances_.begin(), distances_.end()); }
  double mean() const {
    double sum = 0;
    for (const float distance : distances_) sum += distance;
    return sum / static_cast<double>(std::max<std::size_t>(distances_.size(), 1));
  }
  // The least distance that 99 of 100 frames do not exceed.
  double p99() const {
    if (distances_.empty()) return 0;
    std::vector<float> sorted = distances_;
    const auto at = sorted.begin() + static_cast<std::ptrdiff_t>((99 * sorted.size() + 99) / 100 - 1);
    std::nth_element(sorted.begin(), at, sorted.end());
    return *at;
  }

 private:
  std::vector<float> distances_;
};

}  // namespace fb::bake
