#include "bake/baselines/paper_network.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bake/train/checkpoint.h"
#include "base/checked.h"
#include "base/hash.h"

namespace fb::bake {

TrainingPlan paper_plan() {
  TrainingPlan plan;
  plan.epochs = 150;
  return plan;
}

TrainingPlan tuned_plan(std::size_t poses, double visits, const BakeOptions& options) {
  TrainingPlan plan;
  plan.activation = Activation::tanh;
  plan.learning_rate = 4e-3f;
  plan.schedule = Schedule::warmup_stable_decay;
  plan.output_scaling = 1;
  plan.quantised_share = 0.1f;
  plan.batch = poses < 8192 ? 64 : 128;
  plan.microbatch = plan.batch / 2;  // one network: two threads
  plan.epochs = options.epochs
                    ? options.epochs
                    : static_cast<std::uint32_t>(std::clamp(visits / static_cast<double>(poses), 40.0, 400.0));
  plan.seed = options.seed;
  plan.parallel = options.parallel;
  return plan;
}

RegionStats stats_of(const std::string& name, std::size_t vertices, const TrainingSet& set,
                     const TrainedLayers& trained) {
  RegionStats stats;
  stats.name = name;
  stats.vertices = vertices;
  stats.inputs = set.inputs;
  stats.coefficients = set.outputs;
  for (const DenseLayer& layer : trained.layers) stats.parameters += layer.weights.size() + layer.bias.size();
  stats.epochs = trained.epochs;
  stats.restarts = trained.restarts;
  for (const float target : set.targets) stats.energy += double(target) * target;
  stats.validation = trained.validation;
  return stats;
}

void share_energy(std::vector<RegionStats>& regions) {
  double sum = 0;
  for (const RegionStats& region : regions) sum += region.energy;
  for (RegionStats& region : regions) region.energy /= sum > 0 ? sum : 1;
}

std::vector<Feature> identity_features(const RigSchema& schema) {
  std::vector<Feature> features;
  for (const Control& control : schema.controls)
    features.push_back({Feature::Kind::identity, static_cast<std::uint32_t>(features.size()), 1 / control.reach(), 0});
  return features;
}

std::vector<float> identity_values(std::vector<float> controls, const RigSchema& schema) {
  const std::vector<Feature> features = identity_features(schema);
  for (std::size_t i = 0; i < controls.size(); ++i) {
    const std::size_t c = i % features.size();
    controls[i] = (controls[i] - schema.controls[c].rest) * features[c].scale;
  }
  return controls;
}

PrincipalComponents kept_components(const PoseRows& rows, const std::vector<float>& controls, double fraction,
                                    const BakeOptions& options, Progress& progress) {
  const std::filesystem::path kept = options.work / "components.checkpoint";
  const std::size_t samples = std::min<std::size_t>(rows.size(), 16);
  std::vector<float> some(rows.rows() * samples);
  for (std::size_t i = 0; i < samples; ++i)
    rows.read(i * rows.size() / samples, 1, std::span(some).subspan(i * rows.rows(), rows.rows()), options.parallel);
  const std::uint64_t key =
      hash64_of<float>(controls, hash64_of<float>(some, hash64_of<double>(std::span(&fraction, 1))));
  PrincipalComponents pca;
  if (auto saved = load_checkpoint(kept, key); saved && saved->arrays.size() == 3) {
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
      kept,
      {key, 0, {pca.components, pca.coefficients, {static_cast<float>(pca.total), static_cast<float>(pca.captured)}}});
  return pca;
}

RecipeResult paper_network(const PoseSet& poses, const std::vector<float>& coefficients,
                           const std::vector<float>& shapes, TrainingPlan plan,
                           std::span<const std::uint32_t> validation, const BakeOptions& options, Progress& progress) {
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
  result.stats.regions = {stats_of(region.name, model.rest.vertex_count(), set, trained)};
  share_energy(result.stats.regions);
  region.layers = std::move(trained.layers);
  model.network.regions.push_back(std::move(region));
  model.basis =
      make_basis(checked_u32(model.rest.points.size(), "coordinates"), checked_u32(count, "components"), shapes);
  result.packing.first_bits = result.packing.output_bits = 16;  // small layers that rounding to 8 bits shows in most
  std::vector<double> squares(count);
  for (std::size_t i = 0; i < coefficients.size(); ++i) squares[i % count] += double(coefficients[i]) * coefficients[i];
  for (const double sum : squares)
    result.packing.coefficient_sizes.push_back(static_cast<float>(std::sqrt(sum / double(poses.size()))));
  return result;
}

}  // namespace fb::bake
