// The paper's network as we read it: controls -> 8 x 256 ReLU with additive skips -> linear K -> fixed blendshapes that
// hold 99.9 % of the variance; Adam 1e-3 along a cosine, batches of 256 (Radzihovsky, de Goes, Meyer, SIGGRAPH 2020
// Talks).
#include <algorithm>

#include "bake/basis/pca.h"
#include "bake/recipes/recipe.h"
#include "bake/train/checkpoint.h"
#include "bake/train/trainer.h"
#include "base/checked.h"
#include "base/hash.h"

namespace fb {
namespace {

constexpr double variance_held = 0.999;
constexpr std::uint32_t default_epochs = 150;

// The components of these poses, from an earlier, interrupted bake if it got that far.
PrincipalComponents components_of(const PoseSet& poses, const std::vector<float>& controls, const BakeOptions& options,
                                  Progress& progress) {
  const std::filesystem::path kept = options.work / "components.checkpoint";
  std::vector<float> some(poses.source().rest().points.size() * std::min<std::size_t>(poses.size(), 16));
  const PoseSet thin = poses.thinned(16);
  thin.read_displacements(0, thin.size(), some);
  const std::uint64_t key = hash64_of<float>(controls, hash64_of<float>(some));
  PrincipalComponents pca;
  if (auto saved = load_checkpoint(kept, key); saved && saved->arrays.size() == 3) {
    pca.rows = poses.source().rest().points.size();
    pca.components = std::move(saved->arrays[0]);
    pca.coefficients = std::move(saved->arrays[1]);
    pca.count = pca.components.size() / pca.rows;
    pca.total = saved->arrays[2].at(0);
    pca.captured = saved->arrays[2].at(1);
    return pca;
  }
  pca = principal_components(poses, variance_held, options.parallel, progress);
  save_checkpoint(
      kept,
      {key, 0, {pca.components, pca.coefficients, {static_cast<float>(pca.total), static_cast<float>(pca.captured)}}});
  return pca;
}

}  // namespace

FaceModel make_paper(const PoseSet& poses, Source*, const BakeOptions& options, Progress& progress) {
  const RigSchema& schema = poses.source().schema();
  const std::size_t inputs = schema.control_count();
  std::vector<float> features = poses.controls();
  const PrincipalComponents pca = components_of(poses, features, options, progress);

  FaceModel model;
  model.schema = schema;
  model.rest = poses.source().rest();
  Region region{"face", {}, {}};
  for (std::size_t c = 0; c < inputs; ++c) {
    const Control& control = schema.controls[c];
    const float scale = 1 / control.reach();
    model.network.features.push_back({Feature::Kind::identity, static_cast<std::uint32_t>(c), scale, 0});
    region.features.push_back(static_cast<std::uint32_t>(c));
    for (std::size_t pose = 0; pose < poses.size(); ++pose)
      features[pose * inputs + c] = (features[pose * inputs + c] - control.rest) * scale;
  }

  TrainingPlan plan;
  plan.widths.assign(8, 256);
  plan.epochs = options.epochs ? options.epochs : default_epochs;
  plan.seed = options.seed;
  plan.parallel = options.parallel;
  plan.checkpoint = options.work / "network.checkpoint";
  region.layers = train_layers({poses.size(), inputs, pca.count, features, pca.coefficients}, plan, progress).layers;

  model.network.regions.push_back(std::move(region));
  model.basis = make_basis(checked_u32(pca.rows, "coordinates"), checked_u32(pca.count, "components"), pca.components);
  return model;
}

}  // namespace fb
