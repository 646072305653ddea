#include "bake/face/train_region_networks.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <string>

#include "bake/face/network_sizes.h"
#include "bake/face/region_poses.h"
#include "bake/recipe/work_folder.h"
#include "bake/train/trainer.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t min_epochs = 6;

// See TrainingPlan.
constexpr float learning_rate = 8e-3f, hidden_rate_factor = 0.5f, output_rate_factor = 3;
constexpr std::uint32_t batch = 256;
constexpr float residual_init_scale = 0.3f, output_scaling = 0.75f, pose_balance = 0.25f;
// Of the epochs, the last: with weights quantised as they will be packed, of which the networks then lose less.
constexpr float quantised_share = 0.15f;
// Over a training, weight decay alone shrinks a weight by about exp(-total_decay). On a production rig baked from 9,000
// recorded poses, where data is the limit, decay lowered the mse of unseen poses from 2.5e-7 to 2.0e-7.
constexpr double total_decay = 2;
// From recorded poses it grows from so many poses on, up to threefold: there, 6 instead of 2 lowered the mse of random
// poses from 1.8e-7 to 1.3e-7 with 9,000 poses, and raised it by 4 % with 3,000 and by 7 % with 1,000. A short training
// of narrow networks does not tell which is better: with 9,000 poses it preferred 2 by 12 %.
constexpr double decay_poses = 3000, most_decay = 3;

constexpr double flops_per_weight = 6;  // forward, and backward to inputs and to weights: two each
constexpr double pilot_share = 0.03;    // of the recipe's training_flops
constexpr std::uint32_t pilot_width = 64;

// Mean over the poses of the squared coefficients.
double mean_energy(const LocalBasis& basis, std::size_t poses) {
  double sum = 0;
  for (const float c : basis.coefficients) sum += double(c) * c;
  return sum / static_cast<double>(poses);
}

// Squared error over squared coefficients: on validation poses, or on the trained ones where there are none.
double relative_error(const TrainedLayers& trained, const TrainingSet& set) {
  return set.validation.empty() ? trained.loss : trained.validation;
}

// The poses of the face and those of one region, as one training set.
class JoinedPoses {
 public:
  // `face`: of which `columns` are the region's inputs. `own`: the same features in the region's own poses.
  JoinedPoses(const TrainingSet& face, const FeatureTable& own, std::span<const float> own_gates,
              std::span<const float> own_targets)
      : set_(face), targets_(face.targets.begin(), face.targets.end()), gates_(face.gates.begin(), face.gates.end()) {
    features_.reserve((face.poses + own.poses) * face.inputs);
    add_features(face.features, face.stride, face.columns);
    add_features(own.values, own.features.size(), face.columns);
    targets_.insert(targets_.end(), own_targets.begin(), own_targets.end());
    gates_.insert(gates_.end(), own_gates.begin(), own_gates.end());
    set_.poses += own.poses;
    set_.features = features_, set_.targets = targets_, set_.gates = gates_;
    set_.stride = 0, set_.columns = {};
  }
  JoinedPoses(const JoinedPoses&) = delete;
  JoinedPoses& operator=(const JoinedPoses&) = delete;

  const TrainingSet& set() const { return set_; }  // valid as long as this

 private:
  void add_features(std::span<const float> values, std::size_t stride, std::span<const std::uint32_t> columns) {
    for (std::size_t row = 0; row < values.size(); row += stride)
      for (const std::uint32_t column : columns) features_.push_back(values[row + column]);
  }

  TrainingSet set_;
  std::vector<float> features_, targets_, gates_;
};

// The networks of all regions, trained together.
class RegionTraining {
 public:
  RegionTraining(const FaceRecipe& recipe, const BakeOptions& options, std::span<const LocalBasis> bases,
                 const RegionInputs& inputs, const FeatureTable& table, std::span<const std::uint32_t> validation,
                 const Source& source)
      : recipe_(recipe), options_(options), source_(source), poses_(table.poses), recorded_(!inputs.scales.empty()) {
    for (std::size_t r = 0; r < bases.size(); ++r) columns_.push_back(table.columns(inputs.of_region[r]));
    for (std::size_t r = 0; r < bases.size(); ++r) {
      energies.push_back(mean_energy(bases[r], table.poses));
      demands.push_back({columns_[r].size(), bases[r].count, energies[r]});
      TrainingSet set;
      set.poses = table.poses;
      set.inputs = columns_[r].size();
      set.outputs = bases[r].count;
      set.features = table.values;
      set.columns = columns_[r];
      set.stride = table.features.size();
      set.targets = bases[r].coefficients;
      set.gates = table.gates[r];
      if (!inputs.scales.empty()) set.input_scales = inputs.scales[r];
      set.validation = validation;
      sets.push_back(set);
    }
  }

  std::vector<TrainingSet> sets;
  std::vector<double> energies;  // see mean_energy
  std::vector<NetworkDemand> demands;

  // Replaces the expected errors of `demands` by those that narrow networks leave after a short training.
  void run_pilot(Progress& progress) {
    const std::vector<std::uint32_t> widths(sets.size(), pilot_width);
    std::uint32_t epochs = affordable_epochs(widths, pilot_share * recipe_.training_flops, 1);
    if (options_.epochs) epochs = std::min(epochs, options_.epochs);
    const std::vector<TrainedLayers> trained =
        train(widths, epochs, narrow_checkpoint, "training narrow networks", progress);
    for (std::size_t r = 0; r < sets.size(); ++r) demands[r].error *= relative_error(trained[r], sets[r]);
  }

  // Evaluates poses of single regions, more of those of which narrow networks leave more, and adds each region's to its
  // set: none where the rig cannot evaluate one and such poses are skipped. Returns their number.
  std::size_t add_region_poses(RigEvaluator& rig, const SparseBlendshapes& base, std::span<const FaceRegion> regions,
                               std::span<const LocalBasis> bases, const RegionInputs& inputs, Progress& progress) {
    std::vector<double> errors;
    for (const NetworkDemand& demand : demands) errors.push_back(demand.error);
    const std::vector<std::size_t> counts = region_pose_counts(region_pose_count(poses_), errors);
    const PurposeScope purpose(rig, EvaluationPurpose::regions);
    EvaluationStage stage(progress, Phase::training, "evaluating poses of single regions",
                          std::accumulate(counts.begin(), counts.end(), std::size_t{0}));
    std::size_t added = 0;
    for (std::size_t r = 0; r < sets.size(); ++r) {
      if (counts[r] == 0) continue;
      try {
        const RegionPoses own = region_poses(rig, base, regions[r], bases[r], r, counts[r], options_.seed, stage);
        const FeatureTable table = feature_table(inputs, rig.schema(), own.controls, options_.parallel);
        sets[r] = joined_.emplace_back(sets[r], table, table.gates[r], own.coefficients).set();
        added += counts[r];
      } catch (const Error& error) {
        if (!options_.skip_failing || !is_of_pose(error)) throw;
        progress.note(
            format("region \"%s\" is trained on no poses of its own: %s", regions[r].name.c_str(), error.what()));
      }
    }
    return added;
  }

  // The widths of the networks within the recipe's parameters.
  std::vector<std::uint32_t> widths() const {
    const double poses = static_cast<double>(poses_);
    const double share =
        std::clamp(std::cbrt(poses / double(recipe_.full_size_poses)), recipe_.min_parameter_share, 1.0);
    const double parameters = std::min(
        {share * double(recipe_.parameters), double(recipe_.parameters_per_pose) * poses, parameters_of_size()});
    return network_widths(demands, recipe_.hidden_layers, recipe_.max_width, static_cast<std::size_t>(parameters));
  }

  std::vector<TrainedLayers> run(std::span<const std::uint32_t> widths, Progress& progress) const {
    const std::uint32_t epochs =
        options_.epochs ? options_.epochs : affordable_epochs(widths, recipe_.training_flops, min_epochs);
    return train(widths, epochs, "region", "training", progress);
  }

 private:
  // See total_decay.
  double decay() const {
    const double poses = static_cast<double>(sets[0].poses);
    return recorded_ ? total_decay * std::clamp(poses / decay_poses, 1.0, most_decay) : total_decay;
  }

  // What a face of this size may have, see FaceRecipe.
  double parameters_of_size() const {
    const Mesh& rest = source_.rest();
    const double energy = std::accumulate(energies.begin(), energies.end(), 0.0);
    const double residual = std::sqrt(energy / static_cast<double>(rest.vertex_count())) / rest.diagonal();
    const double linear = static_cast<double>(rest.points.size() * source_.schema().control_count());
    return double(recipe_.parameters_per_linear) * linear *
           std::max(1.0, std::pow(residual / recipe_.basis.max_error, 4));
  }

  // Epochs that `flops` suffice for.
  std::uint32_t affordable_epochs(std::span<const std::uint32_t> widths, double flops, std::uint32_t at_least) const {
    double products = 0;
    for (std::size_t r = 0; r < sets.size(); ++r)
      products += static_cast<double>(network_parameters(demands[r], recipe_.hidden_layers, widths[r])) *
                  static_cast<double>(sets[r].poses);
    const double per_epoch = flops_per_weight * products;
    const double most = joined_.empty() ? recipe_.most_epochs : recipe_.most_own_epochs;
    const double epochs = std::clamp(flops / std::max(per_epoch, 1.0), 1.0, most);
    return std::max(static_cast<std::uint32_t>(epochs), at_least);
  }

  std::vector<TrainedLayers> train(std::span<const std::uint32_t> widths, std::uint32_t epochs,
                                   const std::string& checkpoint, std::string_view stage, Progress& progress) const {
    std::vector<TrainingPlan> plans(sets.size());
    for (std::size_t r = 0; r < sets.size(); ++r) {
      TrainingPlan& plan = plans[r];
      const double steps =
          double(epochs) * static_cast<double>((sets[r].poses - sets[r].validation.size()) / batch + 1);
      plan.widths.assign(recipe_.hidden_layers, widths[r]);
      plan.activation = Activation::silu;
      plan.schedule = Schedule::warmup_stable_decay;
      plan.learning_rate = learning_rate;
      plan.hidden_rate_factor = hidden_rate_factor;
      plan.output_rate_factor = output_rate_factor;
      plan.residual_init_scale = residual_init_scale;
      plan.weight_decay = static_cast<float>(decay() / (learning_rate * steps));
      plan.batch = batch;
      plan.output_scaling = output_scaling;
      plan.pose_balance = pose_balance;
      plan.bf16 = true;
      plan.epochs = epochs;
      plan.quantised_share = quantised_share;
      plan.seed = seed_of(options_.seed, Stream::region_networks, r);
      if (!options_.work.empty()) plan.checkpoint = options_.work / format("%s-%zu.checkpoint", checkpoint.c_str(), r);
    }
    return train_in_parallel(sets, plans, options_.parallel, progress, stage);
  }

  const FaceRecipe& recipe_;
  const BakeOptions& options_;
  const Source& source_;
  std::size_t poses_;                                // of the whole face
  bool recorded_;                                    // all was learnt from the poses: the inputs have scales
  std::vector<std::vector<std::uint32_t>> columns_;  // of the feature table, of each region
  std::deque<JoinedPoses> joined_;                   // of regions with poses of their own
};

}  // namespace

RegionNetworks train_region_networks(const FaceRecipe& recipe, std::span<const FaceRegion> regions,
                                     std::span<const LocalBasis> bases, const RegionInputs& inputs,
                                     const TrainingPoses& training_poses, const SparseBlendshapes& base,
                                     RigEvaluator* rig, const BakeOptions& options, Progress& progress) {
  RegionNetworks networks;
  if (regions.empty()) return networks;
  const PoseSet& poses = training_poses.all;
  const FeatureTable table = feature_table(inputs, poses.source().schema(), poses.controls(), options.parallel);
  const Mesh& rest = poses.source().rest();
  RegionTraining training(recipe, options, bases, inputs, table, training_poses.split.validation, poses.source());
  if (regions.size() > 1) training.run_pilot(progress);
  if (rig && options.rig_budget == 0)
    networks.region_poses = training.add_region_poses(*rig, base, regions, bases, inputs, progress);
  const std::vector<std::uint32_t> widths = training.widths();
  const std::vector<TrainedLayers> trained = training.run(widths, progress);

  double squares = 0, energy = 0;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const double error = relative_error(trained[r], training.sets[r]);
    networks.regions.push_back({regions[r].name, inputs.of_region[r], trained[r].layers, inputs.gates[r]});
    networks.stats.push_back({regions[r].name, regions[r].vertices.size(), training.sets[r].inputs, bases[r].count,
                              network_parameters(training.demands[r], recipe.hidden_layers, widths[r]),
                              training.sets[r].poses, regions[r].energy, error, trained[r].epochs,
                              trained[r].restarts});
    squares += error * training.energies[r];
    energy += training.energies[r];
  }
  networks.share_left = energy > 0 ? squares / energy : 0;
  networks.rms_error = std::sqrt(squares / static_cast<double>(rest.vertex_count())) / rest.diagonal();
  return networks;
}

}  // namespace fb::bake
