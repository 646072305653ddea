// hero: the least error that a few minutes of training and 4 MB touched a pose can buy.
#include "bake/recipes/face_recipe.h"

namespace fb {

Learnt make_hero(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress) {
  FaceRecipe recipe;
  recipe.basis.max_error = 5e-4;
  recipe.localize.threshold = 5e-6;
  recipe.parameters = 2'000'000;
  recipe.operations = 6e13;
  return make_face(recipe, poses, rig, options, progress);
}

Learnt make_compact(const PoseSet& poses, Source* rig, const BakeOptions& options, Progress& progress) {
  FaceRecipe recipe;
  recipe.basis.max_error = 1e-3;
  recipe.basis.max_components = 96;
  recipe.localize.threshold = 2e-5;
  recipe.parameters = 350'000;
  recipe.operations = 2e13;
  return make_face(recipe, poses, rig, options, progress);
}

}  // namespace fb
