#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "bake/rig/source.h"

namespace fb::bake {

enum class Interpolation { step, linear, cubic };

// Key frames of an animation, as files store them, and the controls that they move.
struct KeyTrack {
  std::vector<float> times;           // seconds, increasing, at least one
  std::vector<float> values;          // times x controls; of cubic splines times x 3 x controls: for each key its
                                      // in-tangents, its values, its out-tangents, in units a second
  std::vector<std::size_t> controls;  // indices
  Interpolation interpolation = Interpolation::linear;
  bool rotation = false;  // the four controls are a quaternion (x, y, z, w), which turns the short way between keys
};

// Frames from the first key of all tracks to the last, `fps` a second; a last key between two frames becomes a frame of
// its own. A track stays at its ends before and after its keys; controls without a track are at rest (one value a
// control). Where several tracks move a control, the first does, and the control is added to `contested` if they
// disagree. Fails with limit where that would be more than 2^27 values, or more than both 2^24 and 256 for each value
// of the keys: a file of a few bytes could ask for them.
Clip resample(std::span<const KeyTrack> tracks, std::span<const float> rest, double fps,
              std::vector<std::size_t>& contested);

}  // namespace fb::bake
