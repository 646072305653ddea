// Divides training poses into those that are trained on and those that choices are made by.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/rig/pose_set.h"

namespace fb::bake {

// Numbers of poses within a set, ascending; every pose of the set is in one of the two.
struct ValidationSplit {
  std::vector<std::uint32_t> training, validation;
};

// The validation poses are all frames of clips of the split validation, and about `share` (0..1) of the training frames
// of each kind of clip: whole sequences where they are short, else segments of at most 96 consecutive frames, drawn by
// the seed; of shots, a segment may exceed the share, up to a fifth. A shot is one sequence; elsewhere a sequence ends
// where two consecutive frames are about as far apart as any two of their clip, so that neighbours in time stay
// together and poses drawn one by one are sequences of one frame. Excitations are all trained on: no other pose
// replaces them. A kind of which one segment would be more than half gives none. Fails with invalid_argument on a share
// outside its range or a set with frames of a test clip.
ValidationSplit validation_split(const PoseSet& poses, double share, std::uint64_t seed);

// The poses that a face is trained on, and which of them are held back: a twentieth, as validation_split draws them by
// the seed of the bake.
struct TrainingPoses {
  TrainingPoses(const PoseSet& poses, std::uint64_t seed);
  PoseSet fitted() const { return all.picked(split.training); }
  PoseSet held_back() const { return all.picked(split.validation); }  // may be empty

  PoseSet all;
  ValidationSplit split;
};

}  // namespace fb::bake
