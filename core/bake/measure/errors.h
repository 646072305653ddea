// How far a face is from its rig, in the figures every report uses.
#pragma once

#include <cstddef>
#include <span>

#include "bake/measure/histogram.h"

namespace fb::bake {

// With e the distance of a predicted vertex from the true one and D the rest mesh's bounding-box diagonal, over all
// vertices and frames. All are fractions of D.
struct Errors {
  std::size_t frames = 0;
  double mse = 0;   // mean of e^2 / D^2
  double rms = 0;   // its square root
  double mean = 0;  // mean of e / D
  double p99 = 0;   // 99 % of all vertices are nearer; resolved to 1 %
  double max = 0;   // worst vertex of all frames
  double mfm = 0;   // mean over frames of the frame's worst vertex
  std::size_t worst_frame = 0;
};

// Sums errors frame by frame. Partial sums of consecutive frames are joined with `append`, in order, so the figures do
// not depend on how frames were spread over threads (they do depend, in the last digits, on how they were cut in
// blocks).
class ErrorSums {
 public:
  // Both are 3 x vertices floats.
  void add_frame(std::span<const float> predicted, std::span<const float> truth);
  void append(const ErrorSums& later);
  Errors figures(double diagonal) const;

 private:
  std::size_t frames_ = 0, vertices_ = 0, worst_frame_ = 0;
  double squares_ = 0, distances_ = 0, frame_worsts_ = 0, worst_ = 0;
  Histogram histogram_;  // of e^2
};

}  // namespace fb::bake
