#include "bake/train/trainer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "bake/train/checkpoint.h"
#include "bake/train/dense_pass.h"
#include "bake/train/loss_weights.h"
#include "bake/train/optimiser.h"
#include "base/hash.h"
#include "base/random_streams.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t max_restarts = 3, max_validations = 20;

void check(const TrainingSet& set, const TrainingPlan& plan) {
  check_features(set);
  if (set.targets.size() != set.poses * set.outputs)
    fail(Status::invalid_argument, "training: %zu targets for %zu poses of %zu outputs", set.targets.size(), set.poses,
         set.outputs);
  for (std::size_t i = 0; i < set.validation.size(); ++i)
    if (set.validation[i] >= set.poses || (i > 0 && set.validation[i] <= set.validation[i - 1]))
      fail(Status::invalid_argument, "training: validation pose %u of %zu is out of order", set.validation[i],
           set.poses);
  if (!set.input_scales.empty() && set.input_scales.size() != set.inputs)
    fail(Status::invalid_argument, "training: %zu scales for %zu inputs", set.input_scales.size(), set.inputs);
  if (set.validation.size() == set.poses) fail(Status::invalid_argument, "training: all poses are validation poses");
  if (plan.microbatch == 0 || plan.microbatch > DensePass::max_poses)
    fail(Status::invalid_argument, "training: microbatches of %u poses are not 1 to %zu", plan.microbatch,
         DensePass::max_poses);
  if (plan.batch == 0) fail(Status::invalid_argument, "training: batches of 0 poses");
  if (!(plan.output_scaling >= 0 && plan.output_scaling <= 1))
    fail(Status::invalid_argument, "training: output scaling %g is not in [0, 1]", double(plan.output_scaling));
  if (!(plan.pose_balance >= 0 && plan.pose_balance <= 1))
    fail(Status::invalid_argument, "training: pose balance %g is not in [0, 1]", double(plan.pose_balance));
  if (!(plan.quantised_share >= 0 && plan.quantised_share <= 1) || plan.weight_bits < 2 || plan.weight_bits > 16)
    fail(Status::invalid_argument, "training: %d-bit weights (2 to 16) in a share of %g (0 to 1) of the epochs",
         plan.weight_bits, double(plan.quantised_share));
  if (!plan.initial_layers.empty()) {
    const DenseLayer& last = plan.initial_layers.back();
    if (plan.initial_layers.front().inputs != set.inputs || last.outputs != set.outputs ||
        last.activation != Activation::linear || last.skip)
      fail(Status::invalid_argument,
           "training: initial layers take %u inputs to %u outputs, or do not end in a linear layer without residual "
           "connection; the set has %zu inputs and %zu outputs",
           plan.initial_layers.front().inputs, last.outputs, set.inputs, set.outputs);
  }
}

std::vector<std::uint32_t> trained_poses(const TrainingSet& set) {
  std::vector<std::uint32_t> all(set.poses), trained;
  std::iota(all.begin(), all.end(), 0u);
  std::ranges::set_difference(all, set.validation, std::back_inserter(trained));
  return trained;
}

// The inputs alone, poses x inputs, where they are some columns of a wider table: every epoch reads the rows in another
// order, most of them not from a cache. Empty: they are all there is.
std::vector<float> gathered_features(const TrainingSet& set) {
  std::vector<float> features;
  if (set.columns.empty()) return features;
  features.reserve(set.poses * set.inputs);
  const std::size_t stride = set.stride ? set.stride : set.inputs;
  for (std::size_t pose = 0; pose < set.poses; ++pose)
    for (const std::uint32_t column : set.columns) features.push_back(set.features[pose * stride + column]);
  return features;
}

TrainingSet of_gathered(TrainingSet set, std::span<const float> features) {
  if (set.columns.empty()) return set;
  set.features = features;
  set.columns = {};
  set.stride = 0;
  return set;
}

// The order of poses in an epoch: a Fisher-Yates shuffle with a random stream of its own.
void shuffle(std::vector<std::uint32_t>& order, std::uint64_t seed, std::uint64_t epoch) {
  Random random = open_stream(seed, Stream::pose_order, epoch);
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
}

// A hash of everything a checkpoint depends on.
std::uint64_t checkpoint_key(const TrainingSet& set, const TrainingPlan& plan) {
  const auto fixed_point = [](double value) { return static_cast<std::uint64_t>(value * 1e9); };
  std::vector<std::uint64_t> values = {set.poses,
                                       set.inputs,
                                       set.outputs,
                                       set.stride,
                                       plan.batch,
                                       plan.microbatch,
                                       plan.epochs,
                                       plan.seed,
                                       static_cast<std::uint64_t>(plan.activation),
                                       static_cast<std::uint64_t>(plan.schedule),
                                       static_cast<std::uint64_t>(plan.weight_bits),
                                       plan.bf16,
                                       fixed_point(plan.learning_rate),
                                       fixed_point(plan.hidden_rate_factor),
                                       fixed_point(plan.output_rate_factor),
                                       fixed_point(plan.residual_init_scale),
                                       fixed_point(plan.weight_decay),
                                       fixed_point(plan.output_scaling),
                                       fixed_point(plan.pose_balance),
                                       fixed_point(plan.quantised_share)};
  values.insert(values.end(), plan.widths.begin(), plan.widths.end());
  std::uint64_t key = hash64_of<std::uint64_t>(values, hash64_of(set.features, hash64_of(set.targets)));
  key = hash64_of(set.columns, hash64_of(set.validation, hash64_of(set.gates, hash64_of(set.input_scales, key))));
  for (const DenseLayer& layer : plan.initial_layers)
    key = hash64_of<float>(layer.weights, hash64_of<float>(layer.bias, key));
  return key;
}

// One training. A checkpoint holds adam_, best_, best_validation_, epoch_loss_, restarts_ and step_.
class Training {
 public:
  Training(const TrainingSet& set, const TrainingPlan& plan)
      : features_(gathered_features(set)),
        set_(of_gathered(set, features_)),
        plan_(plan),
        shape_(plan.initial_layers.empty() ? NetworkShape(set.inputs, plan, set.outputs)
                                           : NetworkShape(plan.initial_layers)),
        poses_(trained_poses(set)),
        batch_(std::min<std::size_t>(plan.batch, poses_.size())),
        steps_per_epoch_(poses_.size() / batch_),
        steps_(steps_per_epoch_ * plan.epochs),
        key_(plan.checkpoint.empty() ? 0 : checkpoint_key(set_, plan)),
        layer_rate_factors_(layer_rate_factors(shape_, plan)),
        adam_({}),
        passes_((batch_ + plan.microbatch - 1) / plan.microbatch, DensePass(shape_, plan.bf16)) {
    std::vector<double> squares;
    target_squares_ = sum_of_squares(set, poses_, squares);
    if (!(target_squares_ > 0)) fail(Status::bad_data, "training: all coefficients are 0");
    weights_ = loss_weights(set, poses_, plan, squares, target_squares_);
    validation_squares_ = sum_of_squares(set, set.validation, squares);
  }

  TrainedLayers run(Progress& progress) {
    initialise();
    load();
    progress.begin(Phase::training, "training", steps_);
    auto last_save = std::chrono::steady_clock::now();
    while (step_ < steps_) {
      if (!train_step()) restart();
      progress.update(step_);
      const auto now = std::chrono::steady_clock::now();
      if (progress.cancelled() || now - last_save > std::chrono::seconds(30)) {
        save();
        last_save = now;
        progress.step(step_);
      }
    }
    save();
    return result();
  }

 private:
  void initialise() {
    std::vector<float> start;
    if (plan_.initial_layers.empty()) {
      start = initial_parameters(shape_, plan_.residual_init_scale, set_.input_scales, plan_.seed);
    } else {
      start = flatten_layers(shape_, plan_.initial_layers);
      scale_output_layer(start, true);
    }
    adam_ = Adam(std::move(start));
    step_ = 0;
    order_.clear();
    epochs_.clear();
    best_.clear();
    best_validation_ = INFINITY;
  }

  // Starts again at half the learning rate.
  void restart() {
    if (restarts_ == max_restarts)
      fail(Status::internal,
           "training diverged at step %llu of %llu: the loss is not a number, after %u restarts each at half the rate",
           static_cast<unsigned long long>(step_), static_cast<unsigned long long>(steps_), restarts_);
    ++restarts_;
    initialise();
  }

  bool quantised_phase() const {
    return static_cast<double>(step_) >= (1.0 - plan_.quantised_share) * static_cast<double>(steps_);
  }

  // The parameters of the passes: those learnt, or with weights quantised as in the archive.
  const float* pass_parameters(bool quantised) {
    if (!quantised) return adam_.parameters.data();
    quantise_weights(shape_, plan_.weight_bits, adam_.parameters, quantised_, plan_.parallel);
    return quantised_.data();
  }

  // One step of the optimiser; false on divergence: a loss or parameter is not finite.
  bool train_step() {
    const std::uint64_t epoch = step_ / steps_per_epoch_, in_epoch = step_ % steps_per_epoch_;
    if (order_.empty() || in_epoch == 0) {
      order_ = poses_;
      shuffle(order_, plan_.seed, epoch);
      if (in_epoch == 0) epoch_loss_ = 0;
    }
    const std::span<const std::uint32_t> poses = std::span(order_).subspan(in_epoch * batch_, batch_);
    const float* parameters = pass_parameters(quantised_phase());
    std::vector<double> losses(passes_.size());
    parallel_for(plan_.parallel, passes_.size(), [&](std::size_t p, std::size_t) {
      const std::size_t first = p * plan_.microbatch, count = std::min<std::size_t>(plan_.microbatch, batch_ - first);
      losses[p] = passes_[p].loss_and_gradient(set_, poses.subspan(first, count), parameters, weights_,
                                               1.0f / static_cast<float>(batch_));
    });
    const double loss = std::accumulate(losses.begin(), losses.end(), 0.0);
    if (!std::isfinite(loss)) return false;
    epoch_loss_ +=
        loss / target_squares_ * (static_cast<double>(poses_.size()) / static_cast<double>(batch_ * steps_per_epoch_));

    std::vector<const float*> gradients;
    for (const DensePass& pass : passes_) gradients.push_back(pass.gradient().data());
    const double rate =
        std::ldexp(plan_.learning_rate, -static_cast<int>(restarts_)) * schedule_factor(plan_.schedule, step_, steps_);
    adam_.step(shape_, step_, rate, {layer_rate_factors_, set_.input_scales}, plan_.weight_decay, gradients,
               plan_.parallel);
    ++step_;
    return in_epoch + 1 < steps_per_epoch_ || end_epoch(epoch);
  }

  // Measures the validation loss at the ends of at most max_validations epochs, the last included. False on divergence.
  bool end_epoch(std::uint64_t epoch) {
    const std::uint64_t remaining = plan_.epochs - 1 - epoch;
    const std::uint64_t interval = (plan_.epochs + max_validations - 1) / max_validations;
    double validation = epochs_.empty() ? 0 : epochs_.back().validation;
    if (remaining % interval == 0 && !set_.validation.empty()) {
      validation = validate();
      if (!std::isfinite(validation)) return false;
      if (static_cast<float>(validation) < best_validation_) {
        best_validation_ = static_cast<float>(validation);
        best_ = adam_.parameters;
      }
    }
    epochs_.push_back({epoch_loss_, validation});
    return remaining > 0 || std::ranges::all_of(adam_.parameters, [](float value) { return std::isfinite(value); });
  }

  double validate() {
    const float* parameters = pass_parameters(plan_.quantised_share > 0);
    const std::size_t count = set_.validation.size(), microbatch = DensePass::max_poses,
                      microbatches = (count + microbatch - 1) / microbatch;
    std::vector<double> errors(microbatches);
    parallel_for(plan_.parallel, passes_.size(), [&](std::size_t pass, std::size_t) {
      for (std::size_t p = pass; p < microbatches; p += passes_.size())
        errors[p] = passes_[pass].loss(
            set_, set_.validation.subspan(p * microbatch, std::min(microbatch, count - p * microbatch)), parameters,
            weights_);
    });
    return std::accumulate(errors.begin(), errors.end(), 0.0) / std::max(validation_squares_, 1e-30);
  }

  void load() {
    if (plan_.checkpoint.empty()) return;
    auto saved = load_checkpoint(plan_.checkpoint, key_);
    if (!saved || saved->arrays.size() != 5 || saved->arrays[4].size() != 3) return;
    adam_.parameters = std::move(saved->arrays[0]);
    adam_.mean = std::move(saved->arrays[1]);
    adam_.square = std::move(saved->arrays[2]);
    best_ = std::move(saved->arrays[3]);
    best_validation_ = saved->arrays[4][0];
    epoch_loss_ = saved->arrays[4][1];
    restarts_ = static_cast<std::uint32_t>(saved->arrays[4][2]);
    step_ = saved->step;
  }

  void save() const {
    if (plan_.checkpoint.empty()) return;
    save_checkpoint(plan_.checkpoint,
                    {key_,
                     step_,
                     {adam_.parameters,
                      adam_.mean,
                      adam_.square,
                      best_,
                      {best_validation_, static_cast<float>(epoch_loss_), static_cast<float>(restarts_)}}});
  }

  void scale_output_layer(std::vector<float>& parameters, bool to_output_units) const {
    const LayerShape& last = shape_.layers.back();
    for (std::size_t k = 0; k < last.outputs; ++k) {
      const float factor = to_output_units ? 1 / weights_.output_scale[k] : weights_.output_scale[k];
      for (std::size_t i = 0; i < last.inputs; ++i) parameters[last.weights + k * last.inputs + i] *= factor;
      parameters[last.bias + k] *= factor;
    }
  }

  TrainedLayers result() {
    std::vector<float> parameters = best_.empty() ? adam_.parameters : best_;
    scale_output_layer(parameters, false);
    return {unflatten_layers(shape_, parameters), epoch_loss_, std::isfinite(best_validation_) ? best_validation_ : 0,
            epochs_, restarts_};
  }

  const std::vector<float> features_;  // see gathered_features
  const TrainingSet set_;
  const TrainingPlan& plan_;
  const NetworkShape shape_;
  const std::vector<std::uint32_t> poses_;
  const std::size_t batch_;
  const std::uint64_t steps_per_epoch_, steps_, key_;
  LossWeights weights_;
  double target_squares_ = 0, validation_squares_ = 0;

  const std::vector<float> layer_rate_factors_;
  Adam adam_;
  std::uint64_t step_ = 0;
  std::uint32_t restarts_ = 0;
  double epoch_loss_ = 0;             // of this epoch so far
  float best_validation_ = INFINITY;  // loss of best_; a float, as in a checkpoint
  std::vector<float> best_;           // parameters with the least validation loss; empty: none measured
  std::vector<EpochLoss> epochs_;
  std::vector<std::uint32_t> order_;
  std::vector<float> quantised_;
  std::vector<DensePass> passes_;
};

}  // namespace

TrainedLayers train_layers(const TrainingSet& set, const TrainingPlan& plan, Progress& progress) {
  check(set, plan);
  TrainingPlan quiet = plan;  // a training is interrupted between two steps, after writing a checkpoint
  quiet.parallel.progress = nullptr;
  return Training(set, quiet).run(progress);
}

}  // namespace fb::bake
