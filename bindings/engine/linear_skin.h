/** @file
 * The skin of a face on the processor, for engines that take vertices as they are drawn: what joints of the host do to
 * a pose.
 */
#ifndef FACEBAKER_ENGINE_LINEAR_SKIN_H
#define FACEBAKER_ENGINE_LINEAR_SKIN_H

#include <facebaker/facebaker.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "face_pose.h"

namespace facebaker::engine {

/** Moves vertices by the weighted sum of the motions of their joints (linear blend skinning), as fb_joint says. Of one
 * thread at a time. */
class LinearSkin {
 public:
  /** All joints at rest. Throws Error. */
  explicit LinearSkin(const Model& model);

  /** Joints of the face; 0 if it has no skin. */
  std::size_t joint_count() const { return names_.size(); }
  /** Names of joints, in the face's order. */
  const std::vector<std::string>& joint_names() const { return names_; }
  /** How a joint has moved from where it is at rest: `motion` is a frame (the upper three rows of a 4 x 4 matrix) in
   * the archive's axes and units that takes points of the joint at rest to where they are now. False if there is no
   * such joint. */
  bool set_motion(std::uint32_t joint, const float* motion);

  /** Moves positions, normals and tangents of a pose, which driven joints have moved before; outputs are laid
   * out like them. Directions are turned by the same sums and made unit vectors again. A vertex without influences
   * stays. */
  void apply(const PosedFrame& pose, std::vector<float>& positions, std::vector<float>& normals,
             std::vector<float>& tangents) const;

  /** Moves the frame of a driven joint of a pose (PosedFrame::driven_joints) as the skin moves what follows that joint:
   * by the mean of its vertices' sums; of a joint without vertices, those of the joints below it, or else of its
   * parent. `to` may not be `frame`. */
  void move_frame(std::uint32_t driven_joint, const float* frame, float* to) const;

 private:
  // A joint of the host, and how much of what follows a driven joint follows it.
  struct Share {
    std::uint32_t joint;
    float weight;
  };
  void find_shares();

  std::uint32_t influences_ = 0;
  std::size_t vertices_ = 0;
  Model model_;
  std::vector<std::string> names_;
  std::vector<float> at_rest_;   // of each joint: where it is at rest times its inverse bind matrix, 12 floats
  std::vector<float> matrices_;  // of each joint: its motion times that
  std::vector<std::vector<Share>> shares_;  // of each driven joint; they sum to 1, or there are none
};

}  // namespace facebaker::engine

#endif
