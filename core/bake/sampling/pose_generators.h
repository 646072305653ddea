// One generator for each kind of pose. Each returns frames x controls, every value within its range. A pose, or a
// sequence of poses, draws from a random stream of its own, so a longer request begins with the same poses.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/sampling/control_responses.h"
#include "base/random_streams.h"
#include "model/rig_schema.h"

namespace fb::bake {

// One control active at a time: first what is answered, the ends of all ranges and both sides of jumps, then half of
// the poses spread evenly over each range, the other half where chords between the poses so far differ most from the
// rig. Sorted by control and value. Where there are fewer poses than ends, the controls that move most come first.
std::vector<float> make_excitations(const RigSchema& schema, const ControlResponses& responses, std::size_t poses);

// Regional expressions: one to four control groups at once, together about 14 controls.
std::vector<float> make_regional(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                                 std::size_t poses);

// Many controls of all groups at once, on average a third. `heavy`: fewer of them, but most of one group, which is
// drawn in proportion to its share of the motion.
std::vector<float> make_dense(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                              std::size_t poses, bool heavy);

// Poses as in animation: a few expressions at once, each of controls of one group with about equal values, most of them
// on both sides of the face, often to the end of the range, seldom opposed; groups and controls of large motion are
// drawn more often. Other controls then get small values. The number of active controls has a heavy tail: from two to a
// third of all.
std::vector<float> make_performances(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                                     std::size_t poses);

// Smooth sequences of consecutive frames that lead one or two groups from extreme to extreme.
std::vector<float> make_calisthenics(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                                     std::size_t poses);

// Poses near the examples (frames x controls, at least one): up to `frames` of these themselves, far from each other,
// then variations: stronger or weaker, two blended, groups of one with those of another, left and right exchanged where
// names say a side, some controls moved.
std::vector<float> make_like(const RigSchema& schema, const ControlResponses& responses,
                             std::span<const float> examples, std::uint64_t seed, std::size_t poses,
                             std::size_t frames);

// Smoothly interpolates keys (poses of `width` values, one after the other), `step` frames from key to key. Starts one
// frame after the first key and ends when `frames` are made or the last key is reached.
std::vector<float> interpolate_keys(const std::vector<float>& keys, std::size_t width, std::size_t step,
                                    std::size_t frames);

// The value of `control` at `fraction` (0..1) of the way from rest to an end of its range, rounded into the range.
float value_toward(const Control& control, bool up, float fraction);
// Draws an end of the range, in proportion to its distance from rest.
bool draw_end(const Control& control, Random& random);

}  // namespace fb::bake
