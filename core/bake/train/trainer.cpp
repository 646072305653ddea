#include "bake/train/trainer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "bake/train/checkpoint.h"
#include "bake/train/dense_pass.h"
#include "bake/train/optimizer.h"
#include "base/hash.h"
#include "base/random.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr std::uint32_t most_restarts = 3, most_validations = 20;

void check(const TrainingSet& set, const TrainingPlan& plan) {
  check_features(set);
  if (set.targets.size() != set.poses * set.outputs)
    fail(Status::invalid_argument, "training: %zu targets for %zu poses of %zu outputs", set.targets.size(), set.poses,
         set.outputs);
  for (std::size_t i = 0; i < set.validation.size(); ++i)
    if (set.validation[i] >= set.poses || (i > 0 && set.validation[i] <= set.validation[i - 1]))
      fail(Status::invalid_argument, "training: validation pose %u of %zu is out of order", set.validation[i],
           set.poses);
  if (set.validation.size() == set.poses) fail(Status::invalid_argument, "training: all poses are kept for validation");
  if (plan.microbatch == 0 || plan.microbatch > DensePass::most_poses)
    fail(Status::invalid_argument, "training: pieces of %u poses are not 1 to %zu", plan.microbatch,
         DensePass::most_poses);
  if (plan.batch == 0) fail(Status::invalid_argument, "training: batches of no poses");
  if (!(plan.output_scaling >= 0 && plan.output_scaling <= 1))
    fail(Status::invalid_argument, "training: output scaling %g is not in [0, 1]", double(plan.output_scaling));
  if (!(plan.pose_balance >= 0 && plan.pose_balance <= 1))
    fail(Status::invalid_argument, "training: pose balance %g is not in [0, 1]", double(plan.pose_balance));
  if (!(plan.quantized_share >= 0 && plan.quantized_share <= 1) || plan.weight_bits < 2 || plan.weight_bits > 16)
    fail(Status::invalid_argument, "training: %d-bit weights in a share of %g", plan.weight_bits,
         double(plan.quantized_share));
  if (!plan.start.empty()) {
    const DenseLayer& last = plan.start.back();
    if (plan.start.front().inputs != set.inputs || last.outputs != set.outputs ||
        last.activation != Activation::linear || last.skip)
      fail(Status::invalid_argument,
           "training: layers to start from take %u inputs to %u outputs, or do not end linearly; the set has %zu and "
           "%zu",
           plan.start.front().inputs, last.outputs, set.inputs, set.outputs);
  }
}

std::vector<std::uint32_t> trained_poses(const TrainingSet& set) {
  std::vector<std::uint32_t> all(set.poses), trained;
  std::iota(all.begin(), all.end(), 0u);
  std::ranges::set_difference(all, set.validation, std::back_inserter(trained));
  return trained;
}

// The order of poses in an epoch: a Fisher-Yates shuffle of its own stream.
void shuffle(std::vector<std::uint32_t>& order, std::uint64_t seed, std::uint64_t epoch) {
  Random random(seed, 0x10000 + epoch);
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
}

double squares_of(const TrainingSet& set, std::span<const std::uint32_t> poses, std::vector<double>& squares) {
  squares.assign(set.outputs, 0);
  for (const std::uint32_t pose : poses)
    for (std::size_t k = 0; k < set.outputs; ++k)
      squares[k] += double(set.targets[pose * set.outputs + k]) * set.targets[pose * set.outputs + k];
  return std::accumulate(squares.begin(), squares.end(), 0.0);
}

// Adam's step is absolute, so it matters what one unit of an output is.
LossScale loss_scale(const std::vector<double>& squares, double all, std::size_t poses, float scaling) {
  LossScale scales;
  const double size = std::sqrt(all / static_cast<double>(poses * squares.size()));
  const double largest = *std::ranges::max_element(squares);
  for (const double square : squares) {
    const double own = std::sqrt(std::max(square, 1e-8 * largest) / static_cast<double>(poses)) / size;
    scales.unit.push_back(static_cast<float>(size * std::pow(own, scaling)));
    scales.weight.push_back(static_cast<float>(std::pow(own, -0.5 * scaling) / (size * size)));
  }
  return scales;
}

// What each pose's squared error weighs, see TrainingPlan::pose_balance; those never trained on weigh nothing.
std::vector<float> pose_weights(const TrainingSet& set, std::span<const std::uint32_t> poses, double all,
                                float balance) {
  constexpr double least = 0.2;
  const double mean = all / static_cast<double>(poses.size());
  std::vector<float> weights(set.poses);
  double sum = 0;
  for (const std::uint32_t pose : poses) {
    double size = 0;
    for (const float target : set.targets.subspan(pose * set.outputs, set.outputs)) size += double(target) * target;
    weights[pose] = static_cast<float>(std::pow(least + size / mean, -double(balance)));
    sum += weights[pose];
  }
  for (float& weight : weights) weight *= static_cast<float>(static_cast<double>(poses.size()) / sum);
  return weights;
}

// What a checkpoint must have been made from to be gone on with.
std::uint64_t key_of(const TrainingSet& set, const TrainingPlan& plan) {
  const auto millionths = [](double value) { return static_cast<std::uint64_t>(value * 1e9); };
  std::vector<std::uint64_t> numbers = {set.poses,
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
                                        millionths(plan.learning_rate),
                                        millionths(plan.hidden_rate),
                                        millionths(plan.last_rate),
                                        millionths(plan.skip_start),
                                        millionths(plan.weight_decay),
                                        millionths(plan.output_scaling),
                                        millionths(plan.pose_balance),
                                        millionths(plan.quantized_share)};
  numbers.insert(numbers.end(), plan.widths.begin(), plan.widths.end());
  std::uint64_t key = hash64_of<std::uint64_t>(numbers, hash64_of(set.features, hash64_of(set.targets)));
  key = hash64_of(set.columns, hash64_of(set.validation, hash64_of(set.gates, key)));
  for (const DenseLayer& layer : plan.start) key = hash64_of<float>(layer.weights, hash64_of<float>(layer.bias, key));
  return key;
}

// One training on its way: everything that a checkpoint holds is in `adam`, `best` and the numbers after them.
class Training {
 public:
  Training(const TrainingSet& set, const TrainingPlan& plan)
      : set_(set),
        plan_(plan),
        shape_(plan.start.empty() ? NetShape(set.inputs, plan, set.outputs) : NetShape(plan.start)),
        poses_(trained_poses(set)),
        batch_(std::min<std::size_t>(plan.batch, poses_.size())),
        steps_per_epoch_(poses_.size() / batch_),
        steps_(steps_per_epoch_ * plan.epochs),
        key_(plan.checkpoint.empty() ? 0 : key_of(set, plan)),
        layer_rates_(layer_rates(shape_, plan)),
        adam_({}),
        passes_((batch_ + plan.microbatch - 1) / plan.microbatch, DensePass(shape_)) {
    std::vector<double> squares;
    all_squares_ = squares_of(set, poses_, squares);
    if (!(all_squares_ > 0)) fail(Status::bad_data, "training: all coefficients are 0");
    scales_ = loss_scale(squares, all_squares_, poses_.size(), plan.output_scaling);
    if (plan.pose_balance > 0) scales_.pose_weight = pose_weights(set, poses_, all_squares_, plan.pose_balance);
    validation_squares_ = squares_of(set, set.validation, squares);
  }

  TrainedLayers run(Progress& progress) {
    begin();
    load();
    progress.begin("training", steps_);
    auto last_save = std::chrono::steady_clock::now();
    while (step_ < steps_) {
      if (!learn()) restart();
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
  void begin() {
    std::vector<float> start;
    if (plan_.start.empty()) {
      start = initial_parameters(shape_, plan_.skip_start, plan_.seed);
    } else {
      start = parameters_of(shape_, plan_.start);
      scale_last_layer(start, true);
    }
    adam_ = Adam(std::move(start));
    step_ = 0;
    order_.clear();
    epochs_.clear();
    best_.clear();
    best_validation_ = INFINITY;
  }

  // Again, slower.
  void restart() {
    if (restarts_ == most_restarts)
      fail(Status::internal,
           "training diverged at step %llu of %llu: the loss is not a number, after %u restarts each at half the rate",
           static_cast<unsigned long long>(step_), static_cast<unsigned long long>(steps_), restarts_);
    ++restarts_;
    begin();
  }

  bool rounds() const {
    return static_cast<double>(step_) >= (1.0 - plan_.quantized_share) * static_cast<double>(steps_);
  }

  // The weights that poses go through: those learnt, or as the archive will have them.
  const float* weights(bool rounded) {
    if (!rounded) return adam_.parameters.data();
    round_weights(shape_, plan_.weight_bits, adam_.parameters, rounded_, plan_.parallel);
    return rounded_.data();
  }

  // One step; false if its loss, or what it led to, is not a number.
  bool learn() {
    const std::uint64_t epoch = step_ / steps_per_epoch_, in_epoch = step_ % steps_per_epoch_;
    if (order_.empty() || in_epoch == 0) {
      order_ = poses_;
      shuffle(order_, plan_.seed, epoch);
      if (in_epoch == 0) loss_ = 0;
    }
    const std::span<const std::uint32_t> poses = std::span(order_).subspan(in_epoch * batch_, batch_);
    const float* parameters = weights(rounds());
    std::vector<double> losses(passes_.size());
    parallel_for(plan_.parallel, passes_.size(), [&](std::size_t p, std::size_t) {
      const std::size_t first = p * plan_.microbatch, count = std::min<std::size_t>(plan_.microbatch, batch_ - first);
      losses[p] =
          passes_[p].learn(set_, poses.subspan(first, count), parameters, scales_, 1.0f / static_cast<float>(batch_));
    });
    const double loss = std::accumulate(losses.begin(), losses.end(), 0.0);
    if (!std::isfinite(loss)) return false;
    loss_ +=
        loss / all_squares_ * (static_cast<double>(poses_.size()) / static_cast<double>(batch_ * steps_per_epoch_));

    std::vector<const float*> gradients;
    for (const DensePass& pass : passes_) gradients.push_back(pass.gradient().data());
    const double rate =
        std::ldexp(plan_.learning_rate, -static_cast<int>(restarts_)) * schedule_factor(plan_.schedule, step_, steps_);
    adam_.step(shape_, step_, rate, layer_rates_, plan_.weight_decay, gradients, plan_.parallel);
    ++step_;
    return in_epoch + 1 < steps_per_epoch_ || end_epoch(epoch);
  }

  // Validation poses are measured at the ends of at most most_validations epochs, the last among them.
  bool end_epoch(std::uint64_t epoch) {
    const std::uint64_t left = plan_.epochs - 1 - epoch;
    const std::uint64_t apart = (plan_.epochs + most_validations - 1) / most_validations;
    double validation = epochs_.empty() ? 0 : epochs_.back().validation;
    if (left % apart == 0 && !set_.validation.empty()) {
      validation = validate();
      if (!std::isfinite(validation)) return false;
      if (static_cast<float>(validation) < best_validation_) {
        best_validation_ = static_cast<float>(validation);
        best_ = adam_.parameters;
      }
    }
    epochs_.push_back({loss_, validation});
    return left > 0 || std::ranges::all_of(adam_.parameters, [](float value) { return std::isfinite(value); });
  }

  double validate() {
    const float* parameters = weights(plan_.quantized_share > 0);
    const std::size_t count = set_.validation.size(), microbatch = DensePass::most_poses,
                      microbatches = (count + microbatch - 1) / microbatch;
    std::vector<double> errors(microbatches);
    parallel_for(plan_.parallel, passes_.size(), [&](std::size_t pass, std::size_t) {
      for (std::size_t p = pass; p < microbatches; p += passes_.size())
        errors[p] = passes_[pass].test(
            set_, set_.validation.subspan(p * microbatch, std::min(microbatch, count - p * microbatch)), parameters,
            scales_);
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
    loss_ = saved->arrays[4][1];
    restarts_ = static_cast<std::uint32_t>(saved->arrays[4][2]);
    step_ = saved->step;
  }

  void save() const {
    if (plan_.checkpoint.empty()) return;
    save_checkpoint(plan_.checkpoint, {key_,
                                       step_,
                                       {adam_.parameters,
                                        adam_.mean,
                                        adam_.square,
                                        best_,
                                        {best_validation_, static_cast<float>(loss_), static_cast<float>(restarts_)}}});
  }

  void scale_last_layer(std::vector<float>& parameters, bool into_units) const {
    const LayerShape& last = shape_.layers.back();
    for (std::size_t k = 0; k < last.outputs; ++k) {
      const float factor = into_units ? 1 / scales_.unit[k] : scales_.unit[k];
      for (std::size_t i = 0; i < last.inputs; ++i) parameters[last.weights + k * last.inputs + i] *= factor;
      parameters[last.bias + k] *= factor;
    }
  }

  TrainedLayers result() {
    std::vector<float> parameters = best_.empty() ? adam_.parameters : best_;
    scale_last_layer(parameters, false);
    return {layers_of(shape_, parameters), loss_, std::isfinite(best_validation_) ? best_validation_ : 0, epochs_,
            restarts_};
  }

  const TrainingSet& set_;
  const TrainingPlan& plan_;
  const NetShape shape_;
  const std::vector<std::uint32_t> poses_;
  const std::size_t batch_;
  const std::uint64_t steps_per_epoch_, steps_, key_;
  LossScale scales_;
  double all_squares_ = 0, validation_squares_ = 0;

  const std::vector<float> layer_rates_;
  Adam adam_;
  std::uint64_t step_ = 0;
  std::uint32_t restarts_ = 0;
  double loss_ = 0;                   // of this epoch so far
  float best_validation_ = INFINITY;  // of `best_`; a float, as in a checkpoint
  std::vector<float> best_;           // parameters; empty: the last are
  std::vector<EpochLoss> epochs_;
  std::vector<std::uint32_t> order_;
  std::vector<float> rounded_;
  std::vector<DensePass> passes_;
};

}  // namespace

TrainedLayers train_layers(const TrainingSet& set, const TrainingPlan& plan, Progress& progress) {
  check(set, plan);
  return Training(set, plan).run(progress);
}

}  // namespace fb::bake
