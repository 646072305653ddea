#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "commands/pose_evaluator.h"
#include "commands/target_limits.h"
#include "export/low_rank.h"

namespace fb::tool {

// What is written of a clip in place of its frames.
struct MorphedClip {
  std::vector<MorphTargets> meshes;  // the targets of each mesh; the weights are the clip's
  MorphError error;                  // of all frames and meshes
  std::vector<std::string> notes;    // where the targets are others than those that were to be expected
};

// A clip (frames x controls) as morph targets of each mesh over the rest pose: whichever takes less of the columns of
// the basis weighted by the coefficients, and the principal components of the frames, and is nowhere further than the
// tolerance from the evaluated positions. The frames themselves, with a note, where no sums are, as with tolerance 0.
// Positions between frames are interpolated linearly.
MorphedClip morph_clip(PoseEvaluator& evaluator, std::span<const float> controls, const TargetLimits& limits);

// Targets whose sums the frames of a clip are, within rounding and but for exact poses: the frames themselves, or the
// columns of the basis that the clip uses where these are fewer.
class ClipSpan {
 public:
  // The evaluator and the controls must outlive this.
  ClipSpan(PoseEvaluator& evaluator, std::span<const float> controls);

  // Of one mesh, with the weights of the frames, without normals.
  MorphTargets targets(std::size_t mesh) const;

 private:
  PoseEvaluator& evaluator_;
  std::span<const float> controls_;
  std::vector<std::uint32_t> columns_;  // coefficients that are not 0 in every frame
  // Empty where frames are fewer:
  std::vector<float> coefficients_;   // frames x columns
  std::vector<float> displacements_;  // columns x 3 x vertices, for one unit of each
};

// The frames as targets of a mesh, those that move it, without normals.
MorphTargets targets_from_frames(const FrameReader& read, std::size_t frames);

// Frames of a clip for one mesh.
FrameReader frames_of(PoseEvaluator& evaluator, std::span<const float> controls, std::size_t mesh);

// Those frames that move a mesh as targets, without weights and normals; appends their indices to `moved`.
MorphTargets moving_targets(const FrameReader& read, std::size_t frames, std::vector<std::size_t>& moved);

// These columns of a matrix of `width` columns.
std::vector<float> chosen_weights(std::span<const float> weights, std::size_t width,
                                  const std::vector<std::size_t>& chosen);

// How far the evaluated frames of a mesh lie from its targets with their weights.
MorphError error_of(const MorphTargets& morph, const FrameReader& read, std::size_t frames, const Parallel& parallel);

}  // namespace fb::tool
