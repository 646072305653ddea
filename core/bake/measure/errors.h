// Errors of a face against its rig: the figures of every report.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/measure/frame_maxima.h"
#include "bake/measure/histogram.h"
#include "figures/error_figures.h"
#include "model/rig_schema.h"

namespace fb::bake {

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
  double squares_ = 0, distances_ = 0, worst_ = 0;
  double fourth_ = 0;    // squares of the frames' mean squares
  Histogram histogram_;  // of e^2
  FrameMaxima maxima_;
  // Of a channel, over its range.
  struct ChannelSums {
    std::string name;
    double squares = 0, worst = 0;
  };
  std::vector<ChannelSums> channels_;
};

}  // namespace fb::bake
