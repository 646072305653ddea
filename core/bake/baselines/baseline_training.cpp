#include "bake/baselines/baseline_training.h"

#include <algorithm>

namespace fb::bake {

TrainingPlan tuned_plan(std::size_t poses, double pose_visits, const BakeOptions& options) {
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
                    : static_cast<std::uint32_t>(std::clamp(pose_visits / static_cast<double>(poses), 40.0, 400.0));
  plan.seed = options.seed;
  plan.parallel = options.parallel;
  return plan;
}

RegionStats region_stats(const std::string& name, std::size_t vertices, const TrainingSet& set,
                         const TrainedLayers& trained) {
  RegionStats stats;
  stats.name = name;
  stats.vertices = vertices;
  stats.inputs = set.inputs;
  stats.coefficients = set.outputs;
  stats.poses = set.poses;
  for (const DenseLayer& layer : trained.layers) stats.parameters += layer.weights.size() + layer.bias.size();
  stats.epochs = trained.epochs;
  stats.restarts = trained.restarts;
  for (const float target : set.targets) stats.energy += double(target) * target;
  stats.validation = trained.validation;
  return stats;
}

void normalise_energy(std::vector<RegionStats>& regions) {
  double sum = 0;
  for (const RegionStats& region : regions) sum += region.energy;
  for (RegionStats& region : regions) region.energy /= sum > 0 ? sum : 1;
}

}  // namespace fb::bake
