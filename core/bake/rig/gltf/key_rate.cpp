#include "bake/rig/gltf/key_rate.h"

#include <algorithm>
#include <cmath>

namespace fb::bake {
namespace {

// In the order in which they are tried: keys that lie on frames of several rates say nothing.
constexpr double rates[] = {30,  24, 25, 60,  48,  50, 24000 / 1001.0, 30000 / 1001.0, 60000 / 1001.0,
                            100, 72, 90, 120, 144, 240};

bool lies_on_frames(std::span<const KeyTrack> tracks, double start, double fps, double most_apart) {
  return std::ranges::all_of(tracks, [&](const KeyTrack& track) {
    return std::ranges::all_of(track.times, [&](float time) {
      const double frames = (double(time) - start) * fps;
      return std::abs(frames - std::round(frames)) <= most_apart * fps;
    });
  });
}

}  // namespace

FrameRate rate_of(std::span<const KeyTrack> tracks, std::size_t width) {
  constexpr double float_step = 0x1p-23, decimals = 1e-3, near = 1e-3;
  double start = INFINITY, end = -INFINITY;
  for (const KeyTrack& track : tracks) {
    start = std::min<double>(start, track.times.front());
    end = std::max<double>(end, track.times.back());
  }
  // Two steps: the first key is rounded, too.
  const double rounding = 2 * float_step * std::max(std::abs(start), std::abs(end));
  for (const double most_apart : {rounding, decimals})
    for (const double fps : rates)
      if (most_apart * fps < 0.25 && lies_on_frames(tracks, start, fps, most_apart))
        return {fps, std::max(most_apart, near / fps), true};
  for (const double fps : {120.0, 30.0})
    if (frame_count(tracks, fps) * static_cast<double>(width) <= most_values(tracks)) return {fps, 0.5 / fps, false};
  return {30, 0.5 / 30, false};
}

}  // namespace fb::bake
