// The interface of recipes; one file per recipe implements one function of this kind.
#pragma once

#include <optional>
#include <utility>

#include "bake/compress/pack_model.h"
#include "bake/recipe/bake_options.h"
#include "bake/rig/pose_set.h"
#include "bake/rig/rig_evaluator.h"
#include "base/progress.h"
#include "figures/training_figures.h"
#include "model/face_model.h"

namespace fb::bake {

// A trained model, without provenance, how it is to be packed, and statistics.
struct RecipeResult {
  FaceModel model;
  PackOptions packing = {};
  BakeStats stats = {};
  std::vector<std::uint32_t> held_back = {};  // poses of the set that nothing was fitted to, ascending
  std::optional<PackedModel> packed = {};     // pack_model(model, packing), if the recipe packed it to choose `packing`
  std::vector<std::string> warnings = {};     // what was asked for, by the recipe itself too, and is not met
};

// The packed model of a result, packed once.
inline PackedModel take_packed(RecipeResult& result) {
  return result.packed ? std::move(*result.packed) : pack_model(result.model, result.packing);
}

// From what a recipe learns: fits a model, of networks or of anything else, to sampled poses.
enum class Learning { nothing, recordings, all };  // recordings: where there is no live rig, whose controls tell it all

struct Recipe {
  const char* name;
  // `rig` evaluates new poses where there is a live one; null otherwise.
  RecipeResult (*make)(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);
  bool supports_targets = false;  // BakeOptions::max_bytes and max_error
  bool evaluates_rig = false;     // evaluates poses of its own on a live rig, within BakeOptions::rig_budget
  bool keeps_joints = false;      // learns driven joints; others learn what these do to vertices, see JointlessSource
  Learning learning = Learning::all;
};

inline bool learns(const Recipe& recipe, bool live_rig) {
  return recipe.learning == Learning::all || (recipe.learning == Learning::recordings && !live_rig);
}

// What recipes do with a live rig, which decides how it is sampled.
struct RigUse {
  bool evaluates = false;  // see Recipe::evaluates_rig
  bool learns = true;      // from the sampled poses
};

inline RigUse rig_use(const Recipe& recipe) {
  return {recipe.evaluates_rig, learns(recipe, true)};
}

}  // namespace fb::bake
