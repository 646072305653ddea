#pragma once

#include <vector>

#include "bake/rig/composed_source.h"
#include "bake/rig/rig_evaluator.h"

namespace fb::bake {

// Finds how controls of a live rig act on its driven joints one after the other. Controls that turn a joint about
// different axes are moved alone and by pairs: where pairs turn it by one and then the other, the controls come into an
// order, see JointOrder, which is cut into rotations of which each is a sum. Then each control is moved in a few poses
// in which many others turn the joints: what moves a joint there by a part of how it is turned moves its pivot. Returns
// what it found of every joint; nothing where there is nothing. tolerance, over the diagonal: what moves the vertices
// that follow a joint by less, as the root of the sum of squares, is not looked for.
std::vector<JointComposition> compose_joints(RigEvaluator& rig, double tolerance, Progress& progress);

}  // namespace fb::bake
