#include "bake/measure/errors.h"

#include <algorithm>
#include <cmath>

namespace fb::bake {

void ErrorSums::add_frame(std::span<const float> predicted, std::span<const float> truth) {
  const std::size_t vertices = truth.size() / 3;
  double squares = 0, distances = 0, worst = 0;
  std::uint32_t worst_vertex = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double d = double(predicted[3 * v + axis]) - truth[3 * v + axis];
      squared += d * d;
    }
    squares += squared;
    distances += std::sqrt(squared);
    if (squared > worst) {
      worst = squared;
      worst_vertex = static_cast<std::uint32_t>(v);
    }
    histogram_.add(static_cast<float>(squared));
  }
  maxima_.add(worst);
  worst = std::sqrt(worst);
  if (worst > worst_) {
    worst_ = worst;
    worst_frame_ = frames_;
    worst_vertex_ = worst_vertex;
  }
  squares_ += squares;
  fourth_ += std::pow(squares / static_cast<double>(vertices), 2);
  distances_ += distances;
  vertices_ += vertices;
  ++frames_;
}

void ErrorSums::add_channels(std::span<const Channel> channels, std::span<const float> predicted,
                             std::span<const float> truth) {
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const Channel& channel = channels[c];
    if (channels_.size() <= c) channels_.push_back({channel.name});
    const double error =
        (double(channel.value(predicted[c])) - channel.value(truth[c])) / (double(channel.maximum) - channel.minimum);
    channels_[c].squares += error * error;
    channels_[c].worst = std::max(channels_[c].worst, std::abs(error));
  }
}

void ErrorSums::append(const ErrorSums& later) {
  if (later.frames_ == 0) return;
  channels_.resize(later.channels_.size());
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    channels_[c].name = later.channels_[c].name;
    channels_[c].squares += later.channels_[c].squares;
    channels_[c].worst = std::max(channels_[c].worst, later.channels_[c].worst);
  }
  histogram_.append(later.histogram_);
  maxima_.append(later.maxima_);
  if (later.worst_ > worst_) {
    worst_ = later.worst_;
    worst_frame_ = frames_ + later.worst_frame_;
    worst_vertex_ = later.worst_vertex_;
  }
  squares_ += later.squares_;
  fourth_ += later.fourth_;
  distances_ += later.distances_;
  vertices_ += later.vertices_;
  frames_ += later.frames_;
}

Errors ErrorSums::figures(double diagonal) const {
  Errors errors;
  errors.frames = frames_;
  if (frames_ == 0) return errors;
  errors.mse = squares_ / static_cast<double>(vertices_) / (diagonal * diagonal);
  errors.rms = std::sqrt(errors.mse);
  if (errors.mse > 0) {
    const double mean_square = squares_ / static_cast<double>(vertices_), frames = static_cast<double>(frames_);
    const double variance = std::max(0.0, fourth_ / frames - mean_square * mean_square);
    errors.rms_deviation = errors.rms * std::sqrt(variance / frames) / (2 * mean_square);
  }
  errors.mean = distances_ / static_cast<double>(vertices_) / diagonal;
  errors.max = worst_ / diagonal;
  errors.mfm = maxima_.mean() / diagonal;
  errors.worst_frame = worst_frame_;
  errors.worst_vertex = worst_vertex_;
  for (const ChannelSums& channel : channels_)
    errors.channels.push_back({channel.name, std::sqrt(channel.squares / static_cast<double>(frames_)), channel.worst});
  errors.p99 = std::min(std::sqrt(histogram_.p99()) / diagonal, errors.max);
  errors.p99fm = std::min(maxima_.p99() / diagonal, errors.max);
  return errors;
}

}  // namespace fb::bake
