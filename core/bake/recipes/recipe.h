// What every recipe has in common; one file per recipe implements one function of this kind.
#pragma once

#include "bake/quantize/pack_model.h"
#include "bake/recipes/bake.h"
#include "bake/rig/pose_set.h"
#include "model/face_model.h"

namespace fb {

// What a recipe makes of poses: a model, without provenance, how it is to be packed, and how it came about.
struct Learnt {
  FaceModel model;
  PackOptions packing = {};
  BakeDiary diary = {};
};

struct Recipe {
  const char* name;
  // `rig` answers new poses where there is a live one, else null.
  Learnt (*make)(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
  bool fits = false;      // keeps to BakeOptions::max_bytes and max_error
  bool asks_rig = false;  // asks a live rig for poses of its own, within BakeOptions::rig_budget
};

// Fails with not_found, listing the recipes there are.
const Recipe& recipe_named(const std::string& name);

Learnt make_linear(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_kanyuk2018(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_bailey2018(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_paper(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_paper_tuned(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_paper_gradients(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_compact(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);
Learnt make_hero(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress);

// The clips of the split train, without shots for a variant.
PoseSet training_poses(Source& data, Use use);

// bake, once the poses are there.
Baked bake_recorded(Source& data, Source* rig, const BakeOptions& options, Progress& progress);

}  // namespace fb
