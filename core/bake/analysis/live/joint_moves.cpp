#include "bake/analysis/live/joint_moves.h"

#include <algorithm>

#include "bake/analysis/activation_curve.h"

namespace fb::bake {
namespace {

JointMoves moves_of(const DrivenJoints& driven, std::span<const float> coordinates) {
  JointMoves moves(driven.joints.size());
  std::size_t at = 0;
  for (std::size_t j = 0; j < moves.size(); ++j)
    for (const std::uint8_t kind : driven.joints[j].number_kinds()) {
      const double number = double(driven.scales[at]) * coordinates[at];
      ++at;
      if (kind < 3)
        moves[j].turn[kind] = number;
      else if (kind < 6)
        moves[j].move[kind - 3] = number;
    }
  return moves;
}

}  // namespace

void visit_joints(RigEvaluator& rig, const std::vector<std::vector<ControlPlace>>& poses, std::string_view stage_name,
                  Progress& progress, const std::function<void(std::size_t, JointMoves)>& visit) {
  EvaluationStage stage(progress, Phase::sampling, stage_name, poses.size());
  const std::size_t first = rig.rest().first_joint_coordinate();
  rig.evaluate_each(
      poses.size(), stage,
      [&](std::size_t i, std::span<float> pose) {
        for (const auto& [control, position] : poses[i])
          pose[control] = value_at(rig.schema().controls[control], position);
      },
      [&](std::size_t i, std::span<const float>, std::span<float> displacement) {
        visit(i, moves_of(rig.rest().driven, displacement.subspan(first)));
      });
}

std::vector<JointMoves> evaluate_joints(RigEvaluator& rig, const std::vector<std::vector<ControlPlace>>& poses,
                                        std::string_view stage, Progress& progress) {
  std::vector<JointMoves> all(poses.size());
  visit_joints(rig, poses, stage, progress, [&](std::size_t i, JointMoves moves) { all[i] = std::move(moves); });
  return all;
}

std::vector<double> joint_reaches(const DrivenJoints& driven, std::uint32_t which) {
  std::vector<double> reaches;
  std::size_t at = 0;
  for (const DrivenJoint& joint : driven.joints) {
    double& reach = reaches.emplace_back();
    for (const std::uint8_t kind : joint.number_kinds()) {
      if (which >> kind & 1) reach = std::max(reach, 1 / double(driven.scales[at]));
      ++at;
    }
  }
  return reaches;
}

}  // namespace fb::bake
