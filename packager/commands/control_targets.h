#pragma once

#include "commands/pose_animation.h"

namespace fb::tool {

// One morph target a control, over the rest pose: the control by itself at its maximum (at its minimum where it rests
// at the maximum). Targets have the names of the controls, or with arkit_names their ARKit names where they have one;
// a mesh has those that move it. The weights of a pose (controls: frames x controls) are how far each control is on the
// way from rest to there, below 0 on its other side. What controls do in combination is missing; `error` tells how
// much.
MorphedClip morph_controls(PoseEvaluator& evaluator, std::span<const float> controls, bool arkit_names);

}  // namespace fb::tool
