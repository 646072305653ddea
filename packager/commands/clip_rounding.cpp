#include "commands/clip_rounding.h"

#include <algorithm>

#include "base/status.h"

namespace fb::tool {
namespace {

constexpr double usual_tolerance = 1e-5, coarsest_tolerance = 1e-4;  // of the diagonal
constexpr std::size_t most_single_frames = 64;

}  // namespace

std::vector<MorphError> frame_errors(const MorphTargets& morph, const FrameReader& read, std::size_t frames,
                                     const Parallel& parallel) {
  std::vector<MorphError> errors(frames);
  for_frame_blocks(read, frames, [&](std::size_t first, std::size_t count, std::span<const float> moves) {
    const std::size_t size = moves.size() / count;
    parallel_for(parallel, count, [&](std::size_t f, std::size_t) {
      errors[first + f] = morph_error(morph, std::span(morph.weights).subspan((first + f) * morph.count, morph.count),
                                      moves.subspan(f * size, size), 1);
    });
  });
  return errors;
}

ClipRounding::ClipRounding(const MorphTargets& spanning, const FrameReader& read, std::size_t frames,
                           const TargetLimits& limits, double diagonal, const Parallel& parallel)
    : diagonal_(diagonal), wanted_(limits.tolerance.value_or(usual_tolerance * diagonal)) {
  for (const MorphError& error : frame_errors(spanning, read, frames, parallel)) of_frames_.push_back(error.largest);
  if (frames > most_single_frames) {
    std::vector<double> sorted = of_frames_;
    std::ranges::sort(sorted);
    of_most_ = sorted[frames - most_single_frames - 1];
  }
  const double least = 2 * of_most_;
  tolerance_ = limits.tolerance ? wanted_ : std::max(wanted_, least);
  allows_sums_ = least <= tolerance_ && (limits.tolerance || tolerance_ <= coarsest_tolerance * diagonal_);
}

double ClipRounding::room() const {
  double largest = 0;
  for (const double distance : of_frames_)
    if (!is_beside(distance)) largest = std::max(largest, distance);
  return 0.95 * (tolerance_ - largest);  // less than there is, because numbers are rounded
}

bool ClipRounding::all_within() const {
  return std::ranges::all_of(of_frames_, [&](double distance) { return distance <= tolerance_; });
}

MorphTargets ClipRounding::with_frames(const MorphTargets& spanning, const FrameReader& read) const {
  MorphTargets with_frames;
  for (std::size_t f = 0; f < of_frames_.size(); ++f)
    if (is_beside(of_frames_[f])) {
      if (with_frames.count == 0) with_frames = spanning;
      with_frames.add(read(f, 1));
    }
  return with_frames;
}

std::string ClipRounding::coarser_note() const {
  if (tolerance_ <= wanted_) return "";
  return format("its evaluation is rounded by %.1e of the diagonal; its targets are within %.1e", of_most_ / diagonal_,
                tolerance_ / diagonal_);
}

std::string ClipRounding::frames_note() const {
  return format(
      "it lies up to %.1e of the diagonal from what sums of targets give, too far for a tolerance of %.1e: it "
      "has a target a frame",
      of_most_ / diagonal_, tolerance_ / diagonal_);
}

}  // namespace fb::tool
