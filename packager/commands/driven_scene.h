#pragma once

#include "commands/pose_evaluator.h"
#include "export/driven_motion.h"
#include "export/driven_skeleton.h"

namespace fb::tool {

// Poses of a face with driven joints, as a .glb has it: joints that move, a skin, and what is left to meshes.
class DrivenScene {
 public:
  // Both must outlive this. controls: poses x controls.
  DrivenScene(PoseEvaluator& evaluator, std::span<const float> controls);

  // Of the face before driven joints move its vertices.
  PoseEvaluator& unskinned() { return unskinned_; }
  // The character that the file has.
  const CharacterView& character() const { return skeleton_.character(); }
  // Gives a scene of that character the motion of its joints.
  void add_to(GlbScene& scene) const { scene.tracks = skeleton_.tracks(); }
  std::size_t moving_joints() const;
  // How far the file shows vertices from where the face has them.
  MorphError error_of(const GlbScene& scene) const;
  // What programs may show otherwise, in sentences.
  std::vector<std::string> notes() const;

 private:
  FrameReader joint_frames() const;

  PoseEvaluator& evaluator_;
  std::span<const float> controls_;
  PoseEvaluator unskinned_;
  DrivenMotion motion_;
  DrivenSkeleton skeleton_;
};

}  // namespace fb::tool
