// What every recipe has in common; one file per recipe implements one function of this kind.
#pragma once

#include "bake/recipes/bake.h"
#include "bake/rig/pose_set.h"
#include "model/face_model.h"

namespace fb {

struct Recipe {
  const char* name;
  // The model learnt from these poses, without provenance. `rig` answers new poses where there is a live one, else
  // null.
  FaceModel (*make)(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
};

// Fails with not_found, listing the recipes there are.
const Recipe& recipe_named(const std::string& name);

FaceModel make_linear(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
FaceModel make_paper(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
FaceModel make_paper_gradients(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);

// The clips of the split train, without shots for a variant.
PoseSet training_poses(Source& data, Use use);

// bake, once the poses are there.
Baked bake_recorded(Source& data, Source* rig, const BakeOptions& options, Progress& progress);

}  // namespace fb
