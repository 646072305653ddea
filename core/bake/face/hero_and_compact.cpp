// The values of hero, for which a pose of a face of 6,500 vertices may read 4 MB, and of compact, for which it may read
// 1.3 MB.
//
// They trade error against bytes and training time: a larger basis.max_error, a smaller corrective_bytes and fewer
// parameters make a pose cheaper, a larger compression_error_share makes the archive smaller, more training_flops lower
// the error of the networks. Repeat a choice with `bench_packing hero|compact NAME=VALUE... -- SOURCE...`, and with
// `facebaker compare SOURCE --methods hero,compact`.
#include "bake/face/face_recipe.h"

namespace fb::bake {

FaceRecipe hero_recipe() {
  FaceRecipe recipe;
  recipe.basis.max_error = 8e-4;
  recipe.corrective_bytes = 1'000'000;
  recipe.analysis.joint_factor = 10;
  recipe.parameters = 1'400'000;
  recipe.training_flops = 4.5e13;
  recipe.compression_error_share = 0.02;
  recipe.max_bytes_read = 3.75e6;  // on synthetic shots; leaves a margin below 4 MB with what every pose reads
  return recipe;
}

FaceRecipe compact_recipe() {
  FaceRecipe recipe;
  recipe.analysis.curve_tolerance = 2e-4;
  recipe.basis.max_error = 1e-3;
  recipe.basis.max_components = 96;
  recipe.corrective_bytes = 150'000;
  recipe.parameters = 380'000;
  recipe.training_flops = 2.5e13;
  recipe.most_own_epochs = 100;
  recipe.weight_bits = 6;
  recipe.compression_error_share = 0.1;
  recipe.min_compression_error = 1.65e-5;
  recipe.max_bytes_read = 1.1e6;  // on synthetic shots; leaves a margin below 1.3 MB with what every pose reads
  return recipe;
}

RecipeResult make_hero(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  return make_face(hero_recipe(), poses, rig, options, progress);
}

RecipeResult make_compact(const PoseSet& poses, RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  return make_face(compact_recipe(), poses, rig, options, progress);
}

}  // namespace fb::bake
