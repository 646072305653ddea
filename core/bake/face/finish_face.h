// The last step of a recipe: blockwise PCA, and the precision of what is packed.
#pragma once

#include <span>
#include <vector>

#include "bake/compress/blockwise_pca.h"
#include "bake/recipe/recipe.h"
#include "bake/sampling/validation_split.h"

namespace fb::bake {

// The training poses of the set's source that are no shots, which a variant and a backlot have in common; the set
// itself if there are none.
PoseSet without_shots(const PoseSet& poses);

// Root mean square of each direct coefficient over those poses where it is not 0; 1 where it is 0 in all of them.
// Archives then keep a shape as precisely as it is seen each time that it is active.
std::vector<float> direct_sizes(const FaceModel& model, const PoseSet& poses);

// The coefficients of a model in some of the poses, poses x columns: PackOptions::samples.
std::vector<float> sampled_coefficients(const FaceModel& model, const PoseSet& poses, const Parallel& parallel);

// The frames that bounds of what a pose reads hold for on average: synthetic shots (make_test_poses), not those of
// tests. seed: of the bake.
Clip bounded_shots(const RigSchema& schema, std::uint64_t seed);

// Compresses a trained model by blockwise PCA (covariance: see BlockwisePca) and chooses how it is packed.
// With max_bytes or max_error in the options: fit_target, measured as packed on some poses that are held back (of
// all training poses, if none are). Without: as pca_options and packing say, with thresholds and steps multiplied
// by one factor so that frames of bounded_shots read at most max_bytes_read on average, beside what the rest pose
// reads; 0: any number. A factor above 1 is noted. Bytes that cannot be met do not count, with a warning of the result.
RecipeResult finish_face(const FaceModel& model, std::span<const std::vector<float>> covariance,
                         const BlockwisePcaOptions& pca_options, const PackOptions& packing,
                         const TrainingPoses& training, const BakeOptions& options, Progress& progress,
                         double max_bytes_read = 0);

}  // namespace fb::bake
