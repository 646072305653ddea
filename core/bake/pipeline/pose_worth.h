// What the poses that a face is trained on are worth for poses it was not trained on: for reports, never for a choice.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "bake/pipeline/bake.h"
#include "bake/rig/pose_set.h"

namespace fb::bake {

// Poses that are never trained on: the clips of the split test, or of the split validation where there is none of
// those. May be empty.
PoseSet unseen_poses(Source& source);

// coverage_text of the trained poses for the poses asked for; "" if either set is empty.
std::string coverage_of(const PoseSet& trained, const PoseSet& asked, const Parallel& parallel);

// The learning curve of a recipe: it bakes on parts of the poses as learning_curve says and measures on (at most 1,000
// of) the poses asked for. `whole` is the archive already baked on all of the poses. Empty if nothing is asked for, on
// fewer than 16 poses, and, with a note, for a recipe whose calls of the rig are limited.
std::vector<LearningPoint> measure_learning_curve(const PoseSet& poses, const PoseSet& asked,
                                                  std::span<const std::byte> whole, RigEvaluator* rig,
                                                  const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
