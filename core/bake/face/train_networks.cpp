#include "bake/face/train_networks.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "bake/face/network_sizes.h"
#include "bake/sampling/validation_split.h"
#include "bake/train/trainer.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t fewest_epochs = 6, most_epochs = 200;
constexpr double validation_share = 0.05;
constexpr std::uint32_t batch = 128;
constexpr float rate = 4e-3f, hidden_rate = 0.5f, last_rate = 3;  // of learning, see TrainingPlan
constexpr double shrinking = 2;              // over a training, what no pose asks for shrinks by about exp(-shrinking)
constexpr double operations_per_weight = 6;  // forward, and backward to inputs and to weights: two each
constexpr double first_share = 0.03;         // of the operations, for the short training
constexpr std::uint32_t first_width = 64;

double energy_of(const LocalBasis& basis, std::size_t poses) {
  double sum = 0;
  for (const float c : basis.coefficients) sum += double(c) * c;
  return sum / static_cast<double>(poses);
}

// What training of all regions has in common.
struct Course {
  const FaceRecipe& recipe;
  const BakeOptions& options;
  std::vector<TrainingSet> sets;
  std::vector<NetworkDemand> demands;

  // Epochs that `operations` are enough for.
  std::uint32_t epochs(std::span<const std::uint32_t> widths, double operations, std::uint32_t fewest) const {
    double weights = 0;
    for (std::size_t r = 0; r < sets.size(); ++r)
      weights += static_cast<double>(network_parameters(demands[r], recipe.hidden_layers, widths[r]));
    const double per_epoch = operations_per_weight * weights * static_cast<double>(sets[0].poses);
    const double enough = std::clamp(operations / std::max(per_epoch, 1.0), 1.0, double(most_epochs));
    return std::max(static_cast<std::uint32_t>(enough), fewest);
  }

  // `name`: of the checkpoints.
  std::vector<TrainedLayers> run(std::span<const std::uint32_t> widths, std::uint32_t epochs, const std::string& name,
                                 std::string_view stage, Progress& progress) const {
    const double steps = double(epochs) * static_cast<double>((sets[0].poses - sets[0].validation.size()) / batch + 1);
    std::vector<TrainingPlan> plans(sets.size());
    for (std::size_t r = 0; r < sets.size(); ++r) {
      TrainingPlan& plan = plans[r];
      plan.widths.assign(recipe.hidden_layers, widths[r]);
      plan.activation = Activation::silu;
      plan.schedule = Schedule::warmup_stable_decay;
      plan.learning_rate = rate;
      plan.hidden_rate_factor = hidden_rate;
      plan.output_rate_factor = last_rate;
      plan.residual_init_scale = 0.3f;
      plan.weight_decay = static_cast<float>(shrinking / (rate * steps));
      plan.batch = batch;
      plan.output_scaling = 0.75f;
      plan.pose_balance = 0.25f;
      plan.epochs = epochs;
      plan.quantised_share = 0.15f;
      plan.seed = options.seed + r;
      if (!options.work.empty()) plan.checkpoint = options.work / format("%s-%zu.checkpoint", name.c_str(), r);
    }
    return train_in_parallel(sets, plans, options.parallel, progress, stage);
  }
};

// Share of its coefficients' squares that a network leaves, on poses kept back if there are any.
double left_by(const TrainedLayers& trained, const TrainingSet& set) {
  return set.validation.empty() ? trained.loss : trained.validation;
}

}  // namespace

Networks train_networks(const FaceRecipe& recipe, std::span<const FaceRegion> regions,
                        std::span<const LocalBasis> bases, const RegionInputs& inputs, const PoseSet& poses,
                        const BakeOptions& options, Progress& progress) {
  Networks networks;
  const std::size_t count = regions.size();
  if (count == 0) return networks;
  const FeatureTable table = feature_table(inputs, poses, options.parallel);
  const ValidationSplit split = validation_split(poses, validation_share, options.seed);
  Course course{recipe, options, {}, {}};
  std::vector<std::vector<std::uint32_t>> columns;
  std::vector<double> energies;
  for (std::size_t r = 0; r < count; ++r) {
    columns.push_back(table.columns(inputs.of_region[r]));
    energies.push_back(energy_of(bases[r], poses.size()));
    course.demands.push_back({columns[r].size(), bases[r].count, energies[r]});
  }
  for (std::size_t r = 0; r < count; ++r) {
    TrainingSet set;
    set.poses = table.poses;
    set.inputs = columns[r].size();
    set.outputs = bases[r].count;
    set.features = table.values;
    set.columns = columns[r];
    set.stride = table.features.size();
    set.targets = bases[r].coefficients;
    set.gates = table.gates[r];
    set.validation = split.validation;
    course.sets.push_back(set);
  }

  if (count > 1) {
    const std::vector<std::uint32_t> narrow(count, first_width);
    std::uint32_t epochs = course.epochs(narrow, first_share * recipe.operations, 1);
    if (options.epochs) epochs = std::min(epochs, options.epochs);
    const std::vector<TrainedLayers> first = course.run(narrow, epochs, "first", "training narrow networks", progress);
    for (std::size_t r = 0; r < count; ++r) course.demands[r].error *= left_by(first[r], course.sets[r]);
  }
  const double share =
      std::clamp(std::cbrt(double(poses.size()) / double(recipe.ample_poses)), recipe.least_share, 1.0);
  const std::size_t parameters =
      std::min(static_cast<std::size_t>(share * double(recipe.parameters)), recipe.parameters_per_pose * poses.size());
  const std::vector<std::uint32_t> widths =
      network_widths(course.demands, recipe.hidden_layers, recipe.widest, parameters);
  const std::uint32_t epochs =
      options.epochs ? options.epochs : course.epochs(widths, recipe.operations, fewest_epochs);
  const std::vector<TrainedLayers> trained = course.run(widths, epochs, "region", "training", progress);

  const Mesh& rest = poses.source().rest();
  double squares = 0;
  for (std::size_t r = 0; r < count; ++r) {
    const double loss = left_by(trained[r], course.sets[r]);
    networks.regions.push_back({regions[r].name, inputs.of_region[r], trained[r].layers, inputs.gates[r]});
    networks.stats.push_back({regions[r].name, regions[r].vertices.size(), columns[r].size(), bases[r].count,
                              network_parameters(course.demands[r], recipe.hidden_layers, widths[r]), regions[r].energy,
                              loss, trained[r].epochs, trained[r].restarts});
    squares += loss * energies[r];
  }
  networks.rms = std::sqrt(squares / static_cast<double>(rest.vertex_count())) / rest.diagonal();
  return networks;
}

}  // namespace fb::bake
