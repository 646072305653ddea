// The numbers of hero, which may read 4 MB a pose, and of compact, which may read 1.3 MB (see FaceRecipe).
#include "bake/face/face_recipe.h"

namespace fb::bake {

FaceRecipe hero_recipe() {
  FaceRecipe recipe;
  recipe.basis.max_error = 8e-4;
  recipe.corrective_bytes = 1'000'000;
  recipe.parameters = 1'400'000;
  recipe.operations = 4.5e13;
  recipe.precision = 0.02;
  recipe.touched_bytes = 3.9e6;
  return recipe;
}

FaceRecipe compact_recipe() {
  FaceRecipe recipe;
  recipe.analysis.curve_tolerance = 2e-4;
  recipe.basis.max_error = 1e-3;
  recipe.basis.max_components = 96;
  recipe.corrective_bytes = 150'000;
  recipe.parameters = 500'000;
  recipe.operations = 2.5e13;
  recipe.weight_bits = 6;
  recipe.precision = 0.1;
  recipe.finest = 1.5e-5;
  recipe.touched_bytes = 1.25e6;
  return recipe;
}

RecipeResult make_hero(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  return make_face(hero_recipe(), poses, rig, options, progress);
}

RecipeResult make_compact(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  return make_face(compact_recipe(), poses, rig, options, progress);
}

}  // namespace fb::bake
