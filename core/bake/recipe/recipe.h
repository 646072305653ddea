// What every recipe has in common; one file per recipe implements one function of this kind.
#pragma once

#include "bake/compress/pack_model.h"
#include "bake/recipe/bake_options.h"
#include "bake/recipe/bake_stats.h"
#include "bake/rig/pose_set.h"
#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"
#include "model/face_model.h"

namespace fb::bake {

// What a recipe makes of poses: a model, without provenance, how it is to be packed, and how it came about.
struct RecipeResult {
  FaceModel model;
  PackOptions packing = {};
  BakeStats stats = {};
};

struct Recipe {
  const char* name;
  // `rig` evaluates new poses where there is a live one; null otherwise.
  RecipeResult (*make)(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);
  bool fits = false;      // keeps to BakeOptions::max_bytes and max_error
  bool asks_rig = false;  // asks a live rig for poses of its own, within BakeOptions::rig_budget
};

}  // namespace fb::bake
