// The recipes that hero and compact are compared with: linear blendshapes, earlier systems, and the paper's network.
#pragma once

#include "bake/recipe/recipe.h"

namespace fb::bake {

RecipeResult make_linear(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);
RecipeResult make_kanyuk2018(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);
RecipeResult make_bailey2018(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);
RecipeResult make_kavan2024(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);
RecipeResult make_paper(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);
RecipeResult make_paper_tuned(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress);
RecipeResult make_paper_gradients(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options,
                                  Progress& progress);

}  // namespace fb::bake
