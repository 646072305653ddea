#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "commands/target_limits.h"
#include "export/low_rank.h"

namespace fb::tool {

// How far each frame of a mesh lies from its targets with their weights.
std::vector<MorphError> frame_errors(const MorphTargets& morph, const FrameReader& read, std::size_t frames,
                                     const Parallel& parallel);

// How far the frames of a mesh lie from the sums of targets that they are but for the rounding of their evaluation, and
// but for exact poses, and what can be asked of targets that are made of such sums.
class ClipRounding {
 public:
  // spanning: those targets, with the weights of the frames. diagonal: of the face.
  ClipRounding(const MorphTargets& spanning, const FrameReader& read, std::size_t frames, const TargetLimits& limits,
               double diagonal, const Parallel& parallel);

  // How far a point may lie from its frame, a distance: as the limits ask for, or, where they do not and the rounding
  // is coarser than usual, as it allows.
  double tolerance() const { return tolerance_; }
  // Whether sums can be within the tolerance, with a few frames beside them; else each frame has to be a target.
  bool allows_sums() const { return allows_sums_; }
  // What is left of the tolerance for sums that are approximated.
  double room() const;
  // Whether all frames are within the tolerance of the sums as they are.
  bool all_within() const;
  // The targets, and as they are those frames that their sums give too badly; no targets where there is no such frame.
  MorphTargets with_frames(const MorphTargets& spanning, const FrameReader& read) const;

  // Sentences: that the tolerance is not the usual one, or "", and that there is a target a frame.
  std::string coarser_note() const;
  std::string frames_note() const;

 private:
  bool is_beside(double distance) const { return distance > tolerance_ / 2; }

  std::vector<double> of_frames_;
  double of_most_ = 0;  // of all but the worst most_single_frames
  double diagonal_, wanted_, tolerance_;
  bool allows_sums_;
};

}  // namespace fb::tool
