// The paper's network (Radzihovsky, de Goes, Meyer, SIGGRAPH 2020 Talks) in three recipes: `paper` as we read it,
// `paper-gradients` with its other representation, and `paper-tuned` with what the paper leaves open chosen well.
//
// Controls -> 8 hidden layers of 256 with residual connections -> linear layer to K coefficients -> K fixed
// blendshapes, the principal components of the poses.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/baselines/baseline_training.h"
#include "bake/baselines/baselines.h"
#include "bake/baselines/gradient_map.h"
#include "bake/baselines/pca.h"
#include "bake/face/network_inputs.h"
#include "bake/sampling/validation_split.h"
#include "bake/train/checkpoint.h"
#include "base/checked.h"
#include "base/hash.h"

namespace fb::bake {
namespace {

// Share of the variance that the components hold.
constexpr double paper_variance = 0.999, tuned_variance = 0.9999;
constexpr double tuned_pose_visits = 4e6;

// Our reading of the paper's training: ReLU, Adam at 1e-3 along a cosine, batches of 256.
TrainingPlan paper_plan() {
  TrainingPlan plan;
  plan.epochs = 150;
  return plan;
}

// principal_components, or those that an interrupted bake of the same poses and fraction left in the work folder.
PrincipalComponents cached_components(const PoseRows& rows, const std::vector<float>& controls, double fraction,
                                      const BakeOptions& options, Progress& progress) {
  const std::filesystem::path cache = options.work / "components.checkpoint";
  const std::size_t samples = std::min<std::size_t>(rows.size(), 16);
  std::vector<float> sample(rows.rows() * samples);
  for (std::size_t i = 0; i < samples; ++i)
    rows.read(i * rows.size() / samples, 1, std::span(sample).subspan(i * rows.rows(), rows.rows()), options.parallel);
  const std::uint64_t key =
      hash64_of<float>(controls, hash64_of<float>(sample, hash64_of<double>(std::span(&fraction, 1))));
  PrincipalComponents pca;
  if (auto saved = load_checkpoint(cache, key); saved && saved->arrays.size() == 3) {
    pca.rows = rows.rows();
    pca.components = std::move(saved->arrays[0]);
    pca.coefficients = std::move(saved->arrays[1]);
    pca.count = pca.components.size() / pca.rows;
    pca.total = saved->arrays[2].at(0);
    pca.captured = saved->arrays[2].at(1);
    return pca;
  }
  pca = principal_components(rows, fraction, options.parallel, progress);
  save_checkpoint(
      cache,
      {key, 0, {pca.components, pca.coefficients, {static_cast<float>(pca.total), static_cast<float>(pca.captured)}}});
  return pca;
}

// Root mean square of each column of coefficients (poses x count).
std::vector<float> column_rms(const std::vector<float>& coefficients, std::size_t count) {
  std::vector<double> squares(count);
  for (std::size_t i = 0; i < coefficients.size(); ++i) squares[i % count] += double(coefficients[i]) * coefficients[i];
  std::vector<float> rms;
  for (const double sum : squares)
    rms.push_back(static_cast<float>(std::sqrt(sum / double(coefficients.size() / count))));
  return rms;
}

// Trains the network by `plan`, whose widths, seed, threads and checkpoint, and epochs if the options give them, are
// set here. `shapes`: the fixed blendshapes, coefficients x 3 x vertices. `validation`: see TrainingSet.
RecipeResult train_paper_network(const PoseSet& poses, const std::vector<float>& coefficients,
                                 const std::vector<float>& shapes, TrainingPlan plan,
                                 std::span<const std::uint32_t> validation, const BakeOptions& options,
                                 Progress& progress) {
  const RigSchema& schema = poses.source().schema();
  const std::size_t count = coefficients.size() / poses.size();
  RecipeResult result;
  FaceModel& model = result.model;
  model.schema = schema;
  model.rest = poses.source().rest();
  model.network.features = identity_features(schema);
  Region region{"face", {}, {}};
  region.features.resize(schema.control_count());
  std::iota(region.features.begin(), region.features.end(), 0u);

  plan.widths.assign(8, 256);
  if (options.epochs) plan.epochs = options.epochs;
  plan.seed = options.seed;
  plan.parallel = options.parallel;
  plan.checkpoint = options.work / "network.checkpoint";
  const std::vector<float> features = identity_values(poses.controls(), schema);
  const TrainingSet set{poses.size(), schema.control_count(), count, features, coefficients, {}, validation};
  TrainedLayers trained = train_layers(set, plan, progress);
  result.stats.regions = {region_stats(region.name, model.rest.vertex_count(), set, trained)};
  normalise_energy(result.stats.regions);
  region.layers = std::move(trained.layers);
  model.network.regions.push_back(std::move(region));
  model.basis =
      make_basis(checked_u32(model.rest.points.size(), "coordinates"), checked_u32(count, "components"), shapes);
  result.packing.first_bits = result.packing.output_bits = 16;  // the small layers, where 8 bits cost most error
  result.packing.coefficient_sizes = column_rms(coefficients, count);
  return result;
}

}  // namespace

RecipeResult make_paper(const PoseSet& poses, RigEvaluator*, const BakeOptions& options, Progress& progress) {
  const PrincipalComponents pca =
      cached_components(Displacements(poses), poses.controls(), paper_variance, options, progress);
  return train_paper_network(poses, pca.coefficients, pca.components, paper_plan(), {}, options, progress);
}

// Deformation gradients in place of translations, which the paper says gave similar results. The archive holds the
// displacements of each gradient component, so posing needs no Poisson solve.
RecipeResult make_paper_gradients(const PoseSet& poses, RigEvaluator*, const BakeOptions& options, Progress& progress) {
  const GradientMap map(poses.source().rest());
  const PrincipalComponents pca =
      cached_components(GradientRows(poses, map), poses.controls(), paper_variance, options, progress);
  std::vector<float> shapes(pca.components.size());
  parallel_for(options.parallel, pca.count, [&](std::size_t k, std::size_t) {
    map.to_displacements(std::span(pca.components).subspan(k * pca.rows, pca.rows),
                         std::span(shapes).subspan(k * pca.rows, pca.rows));
  });
  return train_paper_network(poses, pca.coefficients, shapes, paper_plan(), {}, options, progress);
}

// The strongest baseline: the same architecture, trained as well as we can.
RecipeResult make_paper_tuned(const PoseSet& poses, RigEvaluator*, const BakeOptions& options, Progress& progress) {
  const PrincipalComponents pca =
      cached_components(Displacements(poses), poses.controls(), tuned_variance, options, progress);
  const ValidationSplit split = validation_split(poses, tuned_validation_share, options.seed);
  return train_paper_network(poses, pca.coefficients, pca.components,
                             tuned_plan(poses.size(), tuned_pose_visits, options), split.validation, options, progress);
}

}  // namespace fb::bake
