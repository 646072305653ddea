// Errors of a face against its rig: the figures of every report.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/histogram.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Errors of a channel over the length of its range, over all frames.
struct ChannelErrors {
  std::string name;
  double rms = 0, max = 0;
};

// With e the distance of a predicted vertex from the true one and D the rest mesh's bounding-box diagonal, over all
// vertices and frames.
struct Errors {
  std::size_t frames = 0;
  double mse = 0;  // mean of e^2 / D^2
  double rms = 0;  // its square root
  // Standard error of rms as that of more such frames, if each was drawn by itself; consecutive ones tell less.
  double rms_deviation = 0;
  double mean = 0;  // mean of e / D
  double p99 = 0;   // 99th percentile of e / D; resolved to 1 %
  double max = 0;   // largest e / D
  double mfm = 0;   // mean over frames of the frame's largest e / D
  std::size_t worst_frame = 0;
  std::uint32_t worst_vertex = 0;  // of that frame
  std::vector<ChannelErrors> channels = {};
};

// Sums errors frame by frame. Partial sums of consecutive blocks of frames are joined with `append`, in order: the
// figures do not depend on the number of threads (in the last digits they depend on the size of the blocks).
class ErrorSums {
 public:
  // Both are 3 x vertices floats.
  void add_frame(std::span<const float> predicted, std::span<const float> truth);
  // The channels of a frame, both as the coordinates that carry them.
  void add_channels(std::span<const Channel> channels, std::span<const float> predicted, std::span<const float> truth);
  void append(const ErrorSums& later);
  Errors figures(double diagonal) const;

 private:
  std::size_t frames_ = 0, vertices_ = 0, worst_frame_ = 0;
  std::uint32_t worst_vertex_ = 0;
  double squares_ = 0, distances_ = 0, frame_worsts_ = 0, worst_ = 0;
  double fourth_ = 0;    // squares of the frames' mean squares
  Histogram histogram_;  // of e^2
  // Of a channel, over its range.
  struct ChannelSums {
    std::string name;
    double squares = 0, worst = 0;
  };
  std::vector<ChannelSums> channels_;
};

}  // namespace fb::bake
