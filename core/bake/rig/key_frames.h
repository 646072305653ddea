#pragma once

#include <cstddef>
#include <span>

#include "bake/rig/source.h"

namespace fb::bake {

// Values that are given at some times, as animation files keep them.
struct KeyFrames {
  std::span<const float> times;   // seconds, increasing, at least one
  std::span<const float> values;  // times x width
  std::size_t width = 0;
  bool step = false;  // a key's values last until the next; otherwise straight lines lead there
};

// Frames from the first key to the last, `fps` a second; a last key between two frames becomes a frame of its own.
// Fails with limit where that would be more than 2^27 values, which a few bytes of keys can ask for.
Clip resample(const KeyFrames& keys, double fps);

}  // namespace fb::bake
