// The recipes hero and compact: sparse blendshapes found by rig analysis, and small networks that learn, region by
// region, the residual. The two differ in the values of FaceRecipe only.
#pragma once

#include <cstddef>

#include "bake/analysis/rig_analysis.h"
#include "bake/recipe/recipe.h"
#include "bake/regions/find_regions.h"
#include "bake/regions/local_basis.h"
#include "bake/sampling/validation_split.h"

namespace fb::bake {

// Bytes are those of a face of at most full_size_vertices; of a larger one they grow with its vertices, as its shapes
// do. Most values can be tried by `bench_packing hero|compact NAME=VALUE... -- SOURCE...`.
struct FaceRecipe {
  AnalysisOptions analysis;
  RegionOptions regions;
  LocalBasisOptions basis;
  // Bytes of correctives that a pose may read on average; pruned ones are left to the networks. Where nothing else
  // needs a network, half of max_bytes_read.
  double corrective_bytes = 0;
  // Parameters of all networks together, distributed by the error each region is expected to leave. With fewer poses
  // than full_size_poses they shrink with the cube root of the number of poses, down to min_parameter_share: on the
  // sample face (8,000 poses) compact lost nothing with 300,000 instead of 500,000 parameters; on a toy rig (900 poses)
  // it got worse with 140,000. parameters_per_pose is a further limit: on the toy rig with 200 poses, more doubled the
  // error.
  // Small faces have at most parameters_per_linear times the numbers of a linear face, 3 x vertices x controls; where
  // the residual (rms at a vertex) is r times basis.max_error, r^4 times as many. On a rig of 64 vertices and 13
  // controls (residual 6e-4), the limit of 20,000 parameters instead of 270,000 left the same error. On one of 64
  // vertices and 4 controls (residual 4e-3, not limited), 98,000 instead of 300,000 left an mse of 5.3e-6 instead
  // of 3.6e-6.
  std::size_t parameters = 0, full_size_poses = 40'000, parameters_per_pose = 2000, parameters_per_linear = 8;
  double min_parameter_share = 0.6;
  // More layers leave less error, and take longer.
  std::uint32_t hidden_layers = 3;
  std::uint32_t max_width = 512;  // of a hidden layer
  // Of a weight in the archive. hero loses little by 7 instead of 8, compact nothing by 6. Training quantises to 8 bits
  // for either; with these bits instead it left no less error.
  int weight_bits = 7;
  double training_flops = 0;  // floating-point operations that training may take, about
  // Epochs that it takes at most, and with poses of single regions: on shots of the sample face, 200 instead of 100
  // lower the worst vertex of `hero` from 4.0e-3 to 3.3e-3, and that of `compact`, whose networks are narrow, not.
  std::uint32_t most_epochs = 200, most_own_epochs = 200;
  // The error that blockwise PCA, quantisation and dropping of columns may add: a share of the networks' own rms error
  // on validation poses, but at least min_compression_error over the diagonal. Where single controls simply add up, the
  // minimum is at most 5e-6.
  double compression_error_share = 0.1, min_compression_error = 1e-6;
  // Per pose on average, beside what the rest pose reads too, whatever the precision (0.15 MB of the sample face).
  // Precision is lowered to keep to it, see finish_face; 0: any.
  double max_bytes_read = 0;
  std::size_t full_size_vertices = 6500;

  double bytes_for(double bytes, std::size_t vertices) const;
};

FaceRecipe hero_recipe();
FaceRecipe compact_recipe();

// A trained face in floats, before quantisation.
struct TrainedFace {
  FaceModel model;
  std::vector<std::vector<float>> covariance;  // of each region's coefficients over the poses, see blockwise_pca
  double rms_error = 0;                        // of the networks, see RegionNetworks
  bool additive = false;  // shapes of single controls only, like morph targets: all error comes from quantisation
  BakeStats stats;
};

// Without a rig, or with a budget too small to analyse it, everything is learnt from the poses.
TrainedFace train_face(const FaceRecipe& recipe, const TrainingPoses& training, RigEvaluator* rig,
                       const BakeOptions& options, Progress& progress);

// train_face, then finish_face.
RecipeResult make_face(const FaceRecipe& recipe, const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options,
                       Progress& progress);

RecipeResult make_compact(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);
RecipeResult make_hero(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);

}  // namespace fb::bake
