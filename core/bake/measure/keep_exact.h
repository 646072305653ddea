#pragma once

#include <span>
#include <string>
#include <vector>

#include "bake/measure/errors.h"
#include "model/packed_model.h"

namespace fb::bake {

// A pose and what the rig gave for it.
struct ExactFrame {
  std::string name;
  std::vector<float> controls;  // within their ranges
  std::vector<float> points;    // of all vertices of the model's mesh, those that carry channels too
};

// Gives a packed model the corrections with which it poses these frames as they are, to a millionth of the diagonal on
// each axis; see ExactPose. They replace those it has. No two frames are closer to each other, nor any to rest, than a
// millionth of the controls' ranges. A correction fades to 0 at the nearest other frame, or half of the way to rest if
// that is nearer.
void keep_exact(PackedModel& model, std::span<const ExactFrame> frames);

// The frames that a model keeps exact, as it poses them itself: within rounding what the rig gave.
std::vector<ExactFrame> exact_frames(const PackedModel& model);

// Errors of a packed model, by the runtime.
Errors exact_errors(const PackedModel& model, std::span<const ExactFrame> frames);

}  // namespace fb::bake
