#include "bake/measure/errors.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace fb {
namespace {

// Squared distances are sorted into bins by exponent and the six leading bits of the fraction: neighbouring bins differ
// by at most 1/64 in e^2, under 1 % in e.
constexpr unsigned dropped_bits = 17;
constexpr std::size_t bins = (0x7f800000u >> dropped_bits) + 1;

std::size_t bin_of(float squared) {
  return std::bit_cast<std::uint32_t>(squared) >> dropped_bits;
}
double upper_edge(std::size_t bin) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(std::min<std::size_t>(bin + 1, bins - 1)) << dropped_bits);
}

}  // namespace

void ErrorSums::add_frame(std::span<const float> predicted, std::span<const float> truth) {
  histogram_.resize(bins);
  const std::size_t vertices = truth.size() / 3;
  double squares = 0, distances = 0, worst = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double d = double(predicted[3 * v + axis]) - truth[3 * v + axis];
      squared += d * d;
    }
    squares += squared;
    distances += std::sqrt(squared);
    worst = std::max(worst, squared);
    ++histogram_[bin_of(static_cast<float>(squared))];
  }
  worst = std::sqrt(worst);
  if (worst > worst_) {
    worst_ = worst;
    worst_frame_ = frames_;
  }
  squares_ += squares;
  distances_ += distances;
  frame_worsts_ += worst;
  vertices_ += vertices;
  ++frames_;
}

void ErrorSums::append(const ErrorSums& later) {
  if (later.frames_ == 0) return;
  histogram_.resize(bins);
  for (std::size_t i = 0; i < bins; ++i) histogram_[i] += later.histogram_[i];
  if (later.worst_ > worst_) {
    worst_ = later.worst_;
    worst_frame_ = frames_ + later.worst_frame_;
  }
  squares_ += later.squares_;
  distances_ += later.distances_;
  frame_worsts_ += later.frame_worsts_;
  vertices_ += later.vertices_;
  frames_ += later.frames_;
}

Errors ErrorSums::figures(double diagonal) const {
  Errors errors;
  errors.frames = frames_;
  if (frames_ == 0) return errors;
  errors.mse = squares_ / static_cast<double>(vertices_) / (diagonal * diagonal);
  errors.rms = std::sqrt(errors.mse);
  errors.mean = distances_ / static_cast<double>(vertices_) / diagonal;
  errors.max = worst_ / diagonal;
  errors.mfm = frame_worsts_ / static_cast<double>(frames_) / diagonal;
  errors.worst_frame = worst_frame_;
  const std::uint64_t beyond = vertices_ / 100;  // vertices allowed past the 99th percentile
  std::uint64_t counted = 0;
  std::size_t bin = bins;
  while (bin > 0 && counted + histogram_[bin - 1] <= beyond) counted += histogram_[--bin];
  errors.p99 = bin == 0 ? 0 : std::min(std::sqrt(upper_edge(bin - 1)) / diagonal, errors.max);
  return errors;
}

}  // namespace fb
