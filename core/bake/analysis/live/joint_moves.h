#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

#include "bake/rig/rig_evaluator.h"
#include "bake/rig/rotation_vector.h"

namespace fb::bake {

// How a driven joint is turned and moved within its parent, in its own axes.
struct JointMove {
  Axis turn = {}, move = {};
};
using JointMoves = std::vector<JointMove>;  // of all driven joints

// A control at a position, see value_at().
using ControlPlace = std::pair<std::uint32_t, double>;

// Calls visit(pose, moves), on several threads, with what a live rig does to its driven joints in each of some poses,
// which are given by the controls that are away from rest.
void visit_joints(RigEvaluator& rig, const std::vector<std::vector<ControlPlace>>& poses, std::string_view stage,
                  Progress& progress, const std::function<void(std::size_t, JointMoves)>& visit);

// The same, all of them.
std::vector<JointMoves> evaluate_joints(RigEvaluator& rig, const std::vector<std::vector<ControlPlace>>& poses,
                                        std::string_view stage, Progress& progress);

// By joint, 0 where it has none of the numbers `which`: how far a unit of one of them moves what follows it, at most;
// of all vertices, see add_joint_vertices().
std::vector<double> joint_reaches(const DrivenJoints& driven, std::uint32_t which);

}  // namespace fb::bake
