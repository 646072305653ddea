#pragma once

#include <cstddef>
#include <span>

#include "bake/rig/source.h"

namespace fb::bake {

// Key frames of an animation, as files store them.
struct KeyFrames {
  std::span<const float> times;   // seconds, increasing, at least one
  std::span<const float> values;  // times x width
  std::size_t width = 0;
  bool step = false;  // values are constant from key to key; otherwise interpolated linearly
};

// Frames from the first key to the last, `fps` a second; a last key between two frames becomes a frame of its own.
// Fails with limit where that would be more than 2^27 values, which a file of a few bytes could require.
Clip resample(const KeyFrames& keys, double fps);

}  // namespace fb::bake
