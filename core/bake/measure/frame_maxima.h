#pragma once

#include <cmath>
#include <cstddef>

#include "bake/measure/histogram.h"

namespace fb::bake {

// Of each frame the distance of its worst vertex. Parts are joined with `append`, like ErrorSums.
class FrameMaxima {
 public:
  void add(double squared_distance) {
    ++frames_;
    sum_ += std::sqrt(squared_distance);
    squares_.add(static_cast<float>(squared_distance));
  }
  void append(const FrameMaxima& later) {
    frames_ += later.frames_;
    sum_ += later.sum_;
    squares_.append(later.squares_);
  }
  // 0 without frames; the percentile is rounded up by less than 1 %.
  double mean() const { return frames_ > 0 ? sum_ / static_cast<double>(frames_) : 0; }
  double p99() const { return std::sqrt(squares_.p99()); }

 private:
  std::size_t frames_ = 0;
  double sum_ = 0;
  Histogram squares_;
};

}  // namespace fb::bake
