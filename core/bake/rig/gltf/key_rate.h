// How often animations are sampled.
#pragma once

#include <cstddef>
#include <span>

#include "bake/rig/gltf/key_frames.h"

namespace fb::bake {

// Of tracks whose frames have `width` values: the first rate in use (30, 24, 25, 60, ... 240 frames a second, those of
// NTSC among them) on whose frames, counted from the first key, all keys lie, but for rounding of floats; or else to a
// millisecond, as of times that were written with three decimals. Where there is none, 120, or 30 where that would be
// too many frames, and every key is moved to the nearest frame.
FrameRate rate_of(std::span<const KeyTrack> tracks, std::size_t width);

}  // namespace fb::bake
