// One generator a kind of pose. Each returns frames x controls, every value within its range; a pose (or a sequence of
// them) draws from a random stream of its own, so a longer request begins with the same poses.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/sampling/control_responses.h"
#include "base/random.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Streams of random numbers that never meet: one set for each use, one stream for each item.
enum class Stream : std::uint64_t {
  regional = 1,
  calisthenics,
  dense,
  heavy,
  random_15,
  random_35,
  synthetic_shots,
  validation,
  performances,
  candidates,
  choice,
  learning_curve,
};

inline Random open_stream(std::uint64_t seed, Stream use, std::uint64_t item) {
  return Random(seed, static_cast<std::uint64_t>(use) << 48 | item);
}

// One control away from rest at a time: first the ends of all ranges, then half of the poses spread evenly over each
// range, and the other half wherever straight lines between the poses so far would miss the rig most. Sorted by control
// and value. With fewer poses than ends, the controls that move most come first.
std::vector<float> make_excitations(const RigSchema& schema, const ControlResponses& responses, std::size_t poses);

// Expressions of one to four regions at once, together about 14 controls.
std::vector<float> make_regional(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                                 std::size_t poses);

// Many controls of all regions at once, on average a third. `heavy`: fewer of them, but most of one region, which is
// drawn in proportion to its share of the motion.
std::vector<float> make_dense(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                              std::size_t poses, bool heavy);

// Poses as animation has them, drawn one by one: a few expressions at once, each of controls of one region that go
// about equally far, most of them on both sides of the face and often to the end, seldom against each other; regions
// and controls that move more of the face come more often; then small tweaks of other controls. How many controls an
// expression asks for has a heavy tail: from two to a third of all.
std::vector<float> make_performances(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                                     std::size_t poses);

// Smooth sequences of consecutive frames that lead one or two regions from extreme to extreme.
std::vector<float> make_calisthenics(const RigSchema& schema, const ControlResponses& responses, std::uint64_t seed,
                                     std::size_t poses);

// The frames of a smooth walk through keys (poses, one after the other, each `width` values), `step` frames from key to
// key; it starts just behind the first key and ends when `frames` are made or the last key is reached.
std::vector<float> walk_through(const std::vector<float>& keys, std::size_t width, std::size_t step,
                                std::size_t frames);

// A value of `control` at `share` (0..1) of the way from rest to an end of its range, rounded into the range.
float toward_end(const Control& control, bool up, float share);
// Draws an end of the range, in proportion to how far it is from rest.
bool draw_end(const Control& control, Random& random);

}  // namespace fb::bake
