#include "bake/rig/key_frames.h"

#include <algorithm>
#include <cmath>

#include "base/status.h"

namespace fb::bake {

Clip resample(const KeyFrames& keys, double fps) {
  const std::span<const float> times = keys.times;
  // Times are rounded: a frame this close to a key is that key.
  const double near = 1e-3 / fps;
  const double start = times.front(), end = times.back();
  const double frames = std::ceil((end - start - near) * fps) + 1;
  if (frames * static_cast<double>(keys.width) > double(1 << 27))
    fail(Status::limit, "%g s of %zu values are too long to be read", end - start, keys.width);
  Clip clip;
  clip.fps = fps;
  clip.frames = static_cast<std::size_t>(frames);
  std::size_t key = 0;
  for (std::size_t f = 0; f < clip.frames; ++f) {
    const double time = std::min(start + static_cast<double>(f) / fps, end);
    while (key + 1 < times.size() && times[key + 1] <= time + near) ++key;
    const std::size_t next = std::min(key + 1, times.size() - 1);
    const bool at_key = keys.step || next == key || time - times[key] < near;
    const double share = at_key ? 0 : (time - times[key]) / (double(times[next]) - times[key]);
    for (std::size_t i = 0; i < keys.width; ++i)
      clip.controls.push_back(static_cast<float>((1 - share) * keys.values[key * keys.width + i] +
                                                 share * keys.values[next * keys.width + i]));
  }
  return clip;
}

}  // namespace fb::bake
