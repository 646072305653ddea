// The last step of a recipe: from what was learnt to what is packed.
#pragma once

#include <span>
#include <vector>

#include "bake/compress/blockwise_pca.h"
#include "bake/recipe/recipe.h"

namespace fb::bake {

// Whether the options name bytes or an error to keep to.
bool asks_target(const BakeOptions& options);

// The training poses of the set's source that are no shots, which a variant and a backlot have alike; the set itself if
// there are none.
PoseSet without_shots(const PoseSet& poses);

// Localizes a model (see blockwise_pca) as precisely as the options ask by max_bytes and max_error, measured as packed
// on some poses kept back by validation_split (on all kinds, if that keeps none). If they ask nothing, as `localize`
// and `packing` say, made coarser together until frames of synthetic shots (see make_test_poses; not those of tests)
// read no more than `touched_bytes` on average (0: any number).
RecipeResult finish_face(const FaceModel& model, std::span<const std::vector<float>> covariance,
                         const BlockwisePcaOptions& localize, const PackOptions& packing, const PoseSet& poses,
                         const BakeOptions& options, Progress& progress, double touched_bytes = 0);

}  // namespace fb::bake
