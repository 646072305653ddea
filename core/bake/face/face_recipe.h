// Our own way to bake: a base of curves and terms that is probed, and small networks that learn, region by region, what
// it leaves over. `hero` and `compact` are this with different numbers.
#pragma once

#include <cstddef>

#include "bake/analysis/rig_analysis.h"
#include "bake/recipe/recipe.h"
#include "bake/regions/find_regions.h"
#include "bake/regions/local_basis.h"

namespace fb::bake {

struct FaceRecipe {
  AnalysisOptions analysis;
  RegionOptions regions;
  LocalBasisOptions basis;
  // Bytes of terms that a pose may read on average; the networks learn what the others would have held.
  double corrective_bytes = 0;
  // Networks: numbers in all of them together, shared out by what each region's residual asks for. With fewer poses
  // than are ample they fall with the cube root of these, down to a share: the sample face, 8,000 poses, comes out no
  // worse with 300,000 numbers than with 500,000 (compact), a toy rig, 900 poses, worse with 140,000. And there are at
  // most so many for each pose: with 200 poses on the toy rig, more doubled the error.
  std::size_t parameters = 0, ample_poses = 40'000, parameters_per_pose = 2000;
  double least_share = 0.6;
  std::uint32_t hidden_layers = 3;
  std::uint32_t widest = 512;
  int weight_bits = 7;    // of a number, as archived; training that reckons with as many instead of 8 leaves no less
  double operations = 0;  // floating-point operations that training may take, about
  // What localizing, rounding and dropping may lose: a share of the networks' own error (root mean square over poses
  // kept back), but never less than `finest` of the diagonal; where single controls add up, no more than 5e-6 of it.
  double precision = 0.1, finest = 1e-6;
  double touched_bytes = 0;  // that a pose may read (see finish_face), a ground for less precision; 0: any
};

FaceRecipe hero_recipe();
FaceRecipe compact_recipe();

// A face of floats: what is known before anything is rounded.
struct TrainedFace {
  FaceModel model;
  std::vector<std::vector<float>> moments;  // of each region's coefficients over the poses, see blockwise_pca
  double rms = 0;                           // what the networks leave at a vertex on poses kept back, over D
  bool adds_up = false;  // nothing but single controls, as morph targets add up: rounding is all that errs
  BakeStats stats;
};

// Without a rig, or with too small a budget to probe it, everything is learnt from the poses.
TrainedFace train_face(const FaceRecipe& recipe, const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options,
                       Progress& progress);

// train_face, then finish_face.
RecipeResult make_face(const FaceRecipe& recipe, const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options,
                       Progress& progress);

RecipeResult make_compact(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);
RecipeResult make_hero(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
