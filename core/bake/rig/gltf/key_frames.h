#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "bake/rig/source.h"

namespace fb::bake {

enum class Interpolation { step, linear, cubic };

// Key frames of an animation, as files store them, and the controls that they move.
struct KeyTrack {
  std::vector<float> times;           // seconds, at least one, none before the one in front of it
  std::vector<float> values;          // times x controls; of cubic splines times x 3 x controls: for each key its
                                      // in-tangents, its values, its out-tangents, in units a second
  std::vector<std::size_t> controls;  // indices
  Interpolation interpolation = Interpolation::linear;
  bool rotation = false;  // the four controls are a quaternion (x, y, z, w), which turns the short way between keys
};

// How animations are sampled.
struct FrameRate {
  double fps = 30;
  double near = 1e-3 / 30;  // seconds: a frame this near to a key is that key
  bool common = true;       // all keys are frames; without, they are moved to the nearest
};

// How many values the frames of tracks may have, and frames that there are at a rate, counting in doubles.
double most_values(std::span<const KeyTrack> tracks);
double frame_count(std::span<const KeyTrack> tracks, double fps);

// Frames from the first key of all tracks to the last; a last key between two frames becomes a frame of its own. Of
// several keys at one time the last counts from there on. A track stays at its ends before and after its keys; controls
// without a track are at rest (one value a control). Where several tracks move a control, the first does, and the
// control is added to `contested` if they disagree. Fails with limit where that would be more than 2^27 values, or more
// than both 2^24 and 256 for each value of the keys: a file of a few bytes could ask for them.
Clip resample(std::span<const KeyTrack> tracks, std::span<const float> rest, const FrameRate& rate,
              std::vector<std::size_t>& contested);

}  // namespace fb::bake
