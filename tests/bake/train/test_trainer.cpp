#include "bake/train/trainer.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <set>

#include "bake/train/checkpoint.h"
#include "bake/train/optimiser.h"
#include "base/file.h"
#include "base/random.h"
#include "base/status.h"
#include "watched_progress.h"

namespace fb::bake::test_trainer {
namespace {

struct Task {
  std::vector<float> features, targets;
  TrainingSet set;
};

// Targets: products and ramps of five features.
Task make_task(std::size_t poses, std::uint64_t seed) {
  Task task;
  Random random(seed);
  for (std::size_t i = 0; i < poses; ++i) {
    float x[5];
    for (float& value : x) task.features.push_back(value = random.uniform(-1, 1));
    for (const float y : {x[0] * x[1], 3 * std::max(x[2], 0.0f) - x[3], x[4] * x[4]}) task.targets.push_back(y);
  }
  task.set = {poses, 5, 3, task.features, task.targets};
  return task;
}

// Forward pass in double.
std::vector<double> outputs(const std::vector<DenseLayer>& layers, const float* input) {
  std::vector<double> x(input, input + layers[0].inputs);
  for (const DenseLayer& layer : layers) {
    std::vector<double> y(layer.outputs);
    for (std::size_t o = 0; o < layer.outputs; ++o) {
      double sum = layer.bias[o];
      for (std::size_t i = 0; i < layer.inputs; ++i) sum += double(layer.weights[o * layer.inputs + i]) * x[i];
      if (layer.activation == Activation::relu) sum = std::max(sum, 0.0);
      if (layer.activation == Activation::tanh) sum = std::tanh(sum);
      if (layer.activation == Activation::silu) sum = sum / (1 + std::exp(-sum));
      y[o] = sum + (layer.skip ? x[o] : 0);
    }
    x = y;
  }
  return x;
}

double relative_error(const std::vector<DenseLayer>& layers, const Task& task) {
  const float zero[5] = {};
  const std::vector<double> rest = outputs(layers, zero);
  double error = 0, size = 0;
  for (std::size_t i = 0; i < task.set.poses; ++i) {
    const std::vector<double> y = outputs(layers, task.features.data() + 5 * i);
    for (std::size_t k = 0; k < 3; ++k) {
      const double t = task.targets[3 * i + k];
      error += (y[k] - rest[k] - t) * (y[k] - rest[k] - t);
      size += t * t;
    }
  }
  return error / size;
}

TrainingPlan plan_of(std::uint32_t epochs, int threads = 0, bool bf16 = false) {
  TrainingPlan plan;
  plan.widths = {48, 48, 48};
  plan.learning_rate = 3e-3f;
  plan.epochs = epochs;
  plan.parallel.threads = threads;
  plan.bf16 = bf16;
  return plan;
}

// Scale and weight of each coefficient by the formula of output_scaling, weight of each pose by that of pose_balance.
struct ReferenceWeights {
  double output_scale[3], output_weight[3];
  std::vector<double> pose_weight;
};

ReferenceWeights reference_weights(const Task& task, double scaling, double balance) {
  double squares[3] = {};
  for (std::size_t i = 0; i < task.targets.size(); ++i) squares[i % 3] += double(task.targets[i]) * task.targets[i];
  const double poses = double(task.set.poses), all = std::sqrt((squares[0] + squares[1] + squares[2]) / (3 * poses));
  ReferenceWeights weights;
  for (int k = 0; k < 3; ++k) {
    const double relative = std::sqrt(squares[k] / poses) / all;
    weights.output_scale[k] = all * std::pow(relative, scaling);
    weights.output_weight[k] = std::pow(relative, -scaling / 2) / (all * all);
  }
  double sum = 0;
  for (std::size_t i = 0; i < task.set.poses; ++i) {
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k) square += std::pow(double(task.targets[3 * i + k]), 2);
    weights.pose_weight.push_back(std::pow(0.2 + square / (3 * all * all), -balance));
    sum += weights.pose_weight.back();
  }
  for (double& weight : weights.pose_weight) weight *= poses / sum;
  return weights;
}

// The training loss by definition: the mean over all poses of the weighted squares of
// gate * (outputs - outputs at rest) - targets.
double loss_of(const std::vector<DenseLayer>& layers, const Task& task, const ReferenceWeights& weights) {
  const float zero[5] = {};
  const std::vector<double> rest = outputs(layers, zero);
  double sum = 0;
  for (std::size_t i = 0; i < task.set.poses; ++i) {
    const std::vector<double> y = outputs(layers, task.features.data() + 5 * i);
    const double gate = task.set.gates.empty() ? 1 : task.set.gates[i];
    for (std::size_t k = 0; k < 3; ++k)
      sum += weights.pose_weight[i] * weights.output_weight[k] *
             std::pow(gate * (y[k] - rest[k]) * weights.output_scale[k] - task.targets[3 * i + k], 2);
  }
  return sum / double(task.set.poses);
}

// Every trained parameter: weights, and the biases of all layers but the last.
std::vector<float*> parameters_of(std::vector<DenseLayer>& layers) {
  std::vector<float*> parameters;
  for (DenseLayer& layer : layers) {
    for (float& weight : layer.weights) parameters.push_back(&weight);
    if (&layer != &layers.back())
      for (float& bias : layer.bias) parameters.push_back(&bias);
  }
  return parameters;
}

bool same(const std::vector<DenseLayer>& a, const std::vector<DenseLayer>& b) {
  for (std::size_t l = 0; l < a.size(); ++l)
    if (a[l].weights != b[l].weights || a[l].bias != b[l].bias) return false;
  return a.size() == b.size();
}

struct StopAfter final : test::QuietProgress {
  explicit StopAfter(std::uint64_t steps) : steps(steps) {}
  void update(std::uint64_t done) override { stopped = done >= steps; }
  bool cancelled() const override { return stopped; }
  std::uint64_t steps;
  bool stopped = false;
};

}  // namespace

TEST_CASE("training learns products and ramps of poses it has not seen") {
  const Task task = make_task(4000, 1), unseen = make_task(500, 2);
  for (const bool bf16 : {false, true}) {
    const TrainedLayers trained = train_layers(task.set, plan_of(40, 0, bf16), silent_progress());
    CHECK((trained.layers.size() == 4 && trained.layers[3].activation == Activation::linear));
    CHECK((!trained.layers[0].skip && trained.layers[1].skip));
    CHECK(std::max(trained.loss, relative_error(trained.layers, unseen)) < 0.01);
    CHECK(relative_error(trained.layers, task) == doctest::Approx(trained.loss).epsilon(0.5));
  }
}

namespace {

// Trains a few steps and checks each against Adam's formula on a gradient by finite differences.
void check_steps(const Task& task, TrainingPlan plan, const std::vector<double>& factors) {
  const ReferenceWeights weights = reference_weights(task, plan.output_scaling, plan.pose_balance);
  plan.epochs = 0;
  std::vector<DenseLayer> start = train_layers(task.set, plan, silent_progress()).layers;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 8; ++i) start.back().weights[8 * k + i] /= static_cast<float>(weights.output_scale[k]);
  std::vector<DenseLayer> layers = start;
  const std::vector<float*> parameters = parameters_of(layers);
  std::vector<double> mean(parameters.size()), square(parameters.size());
  const std::size_t steps = factors.size();
  for (std::size_t step = 0; step < steps; ++step) {
    std::vector<double> gradient;
    for (float* parameter : parameters) {
      const float kept = *parameter;
      const auto loss_at = [&](float value) {
        *parameter = value;
        return loss_of(layers, task, weights);
      };
      // One-sided for ReLU, which has no derivative at 0; central for smooth activations.
      const float up = plan.activation == Activation::relu ? kept : kept + 1e-3f;
      const float down = plan.activation == Activation::relu ? kept - 1e-4f : kept - 1e-3f;
      gradient.push_back((loss_at(up) - loss_at(down)) / (double(up) - down));
      *parameter = kept;
    }
    const double rate = plan.learning_rate * factors[step];
    std::size_t at = 0;
    for (DenseLayer& layer : layers) {
      const std::size_t weight_count = layer.weights.size(),
                        count = weight_count + (&layer == &layers.back() ? 0 : layer.bias.size());
      const double rate_factor = &layer == &layers.front()  ? 1
                                 : &layer == &layers.back() ? plan.output_rate_factor
                                                            : plan.hidden_rate_factor;
      for (std::size_t i = 0; i < count; ++i, ++at) {
        mean[at] = 0.9 * mean[at] + 0.1 * gradient[at];
        square[at] = 0.999 * square[at] + 0.001 * gradient[at] * gradient[at];
        const double m = mean[at] / (1 - std::pow(0.9, step + 1)), v = square[at] / (1 - std::pow(0.999, step + 1));
        const double kept = i < weight_count ? 1 - rate * plan.weight_decay : 1;
        const bool of_input = &layer == &layers.front() && i < weight_count && !task.set.input_scales.empty();
        const double input_factor = of_input ? task.set.input_scales[i % 5] : 1;
        const double layer_rate = i < weight_count ? rate * rate_factor * input_factor : rate;
        *parameters[at] = static_cast<float>(*parameters[at] * kept - layer_rate * m / (std::sqrt(v) + 1e-8));
      }
    }
  }
  plan.epochs = static_cast<std::uint32_t>(steps);
  std::vector<DenseLayer> trained = train_layers(task.set, plan, silent_progress()).layers;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 8; ++i)
      trained.back().weights[8 * k + i] /= static_cast<float>(weights.output_scale[k]);
  const std::vector<float*> got = parameters_of(trained), before = parameters_of(start);
  double off = 0, moved = 0;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    off += std::abs(double(*got[i]) - *parameters[i]);
    moved += std::abs(double(*got[i]) - *before[i]);
  }
  CHECK(moved > 0.1);
  CHECK(off < 0.02 * moved);
  CHECK(trained.back().bias == std::vector<float>(3));
}

// Half a cosine over five steps.
std::vector<double> half_cosine() {
  std::vector<double> factors;
  for (int step = 0; step < 5; ++step) factors.push_back(0.5 * (1 + std::cos(M_PI * step / 5)));
  return factors;
}

}  // namespace

TEST_CASE("steps are those of Adam on the gradient of the loss, for every activation") {
  const Task task = make_task(50, 5);  // fewer than a batch, so that each step is on all
  TrainingPlan plan = plan_of(0);
  plan.widths = {8, 8, 8};
  for (const Activation activation : {Activation::relu, Activation::tanh, Activation::silu, Activation::linear}) {
    CAPTURE(static_cast<int>(activation));
    plan.activation = activation;
    check_steps(task, plan, half_cosine());
  }
}

TEST_CASE("steps are those of Adam with gates, scaled outputs and decay, and without residual connections") {
  Task task = make_task(50, 6);
  std::vector<float> gates;
  Random random(3);
  for (std::size_t i = 0; i < task.set.poses; ++i) gates.push_back(std::max(random.uniform(-1, 1), 0.0f));
  TrainingPlan plan = plan_of(0);
  plan.activation = Activation::silu;
  plan.widths = {8, 6, 8};  // no residual connection fits
  check_steps(task, plan, half_cosine());
  plan.widths = {8, 8};
  SUBCASE("gates") {
    task.set.gates = gates;
  }
  SUBCASE("each output in its own unit") {
    plan.output_scaling = 1;
  }
  SUBCASE("halfway") {
    plan.output_scaling = 0.5f;
  }
  SUBCASE("small microbatches") {
    plan.microbatch = 7;
  }
  SUBCASE("poses balanced") {
    plan.pose_balance = 1;
  }
  SUBCASE("decay") {
    plan.weight_decay = 5;
  }
  SUBCASE("rate factors of layers") {
    plan.hidden_rate_factor = 0.5f;
    plan.output_rate_factor = 3;
  }
  const std::vector<float> scales = {1, 0.1f, 2, 0.5f, 0.01f};
  SUBCASE("inputs of different strength") {
    task.set.input_scales = scales;
    plan.weight_decay = 5;
  }
  SUBCASE("all of it") {
    task.set.input_scales = scales;
    plan.hidden_rate_factor = 0.5f;
    plan.output_rate_factor = 2;
    task.set.gates = gates;
    plan.output_scaling = 1;
    plan.pose_balance = 0.5f;
    plan.weight_decay = 5;
  }
  check_steps(task, plan, half_cosine());
}

TEST_CASE("the warmup-stable-decay schedule rises, stays, and falls linearly") {
  const Task task = make_task(100, 7);
  TrainingPlan plan = plan_of(0);
  plan.widths = {8, 8};
  plan.activation = Activation::silu;
  plan.schedule = Schedule::warmup_stable_decay;
  check_steps(task, plan, {1, 1, 1, 1, 2 * (1 - 4 / 6.0), 2 * (1 - 5 / 6.0)});
  CHECK(schedule_factor(Schedule::warmup_stable_decay, 0, 1000) == doctest::Approx(1 / 30.0));
  CHECK(schedule_factor(Schedule::warmup_stable_decay, 14, 1000) == doctest::Approx(0.5));
  CHECK(schedule_factor(Schedule::warmup_stable_decay, 29, 1000) == 1);
  CHECK(schedule_factor(Schedule::warmup_stable_decay, 500, 1000) == 1);
  CHECK(schedule_factor(Schedule::warmup_stable_decay, 750, 1000) == doctest::Approx(0.5));
  CHECK(schedule_factor(Schedule::warmup_stable_decay, 999, 1000) == doctest::Approx(0.002));
  CHECK(schedule_factor(Schedule::cosine, 250, 500) == doctest::Approx(0.5));
}

// Weights quantised to multiples of their row's largest over 2^(bits - 1) - 1.
static std::vector<DenseLayer> quantised(std::vector<DenseLayer> layers, int bits) {
  for (DenseLayer& layer : layers)
    for (std::size_t o = 0; o < layer.outputs; ++o) {
      const std::span<float> row = std::span(layer.weights).subspan(o * layer.inputs, layer.inputs);
      double top = 0;
      for (const float weight : row) top = std::max(top, std::abs(double(weight)));
      const double step = top / ((1 << (bits - 1)) - 1);
      for (float& weight : row) weight = static_cast<float>(std::nearbyint(weight / step) * step);
    }
  return layers;
}

TEST_CASE("quantisation-aware training leaves less error once weights are quantised") {
  const Task task = make_task(1000, 1), unseen = make_task(500, 2);
  TrainingPlan plan = plan_of(40);
  plan.batch = 32;
  plan.activation = Activation::silu;
  plan.weight_bits = 5;
  const std::vector<DenseLayer> plain = train_layers(task.set, plan, silent_progress()).layers;
  plan.quantised_share = 0.4f;
  const std::vector<DenseLayer> aware = train_layers(task.set, plan, silent_progress()).layers;
  CHECK(relative_error(quantised(plain, 5), unseen) > 1.4 * relative_error(plain, unseen));
  CHECK(relative_error(quantised(aware, 5), unseen) < 0.8 * relative_error(quantised(plain, 5), unseen));
}

TEST_CASE("nonlinear layers learn what linear ones cannot") {
  const Task task = make_task(1000, 1), unseen = make_task(500, 2);
  TrainingPlan plan = plan_of(40);
  plan.batch = 32;
  plan.activation = Activation::linear;
  CHECK(relative_error(train_layers(task.set, plan, silent_progress()).layers, unseen) > 0.1);
  for (const Activation activation : {Activation::silu, Activation::tanh}) {
    plan.activation = activation;
    CHECK(relative_error(train_layers(task.set, plan, silent_progress()).layers, unseen) < 0.01);
  }
}

TEST_CASE("the weights with the least validation loss are kept, and validation poses are not trained on") {
  Task task = make_task(160, 1);
  Random noise(9);
  for (float& target : task.targets) target += noise.normal();  // so that training overfits
  std::vector<std::uint32_t> validation;
  for (std::uint32_t pose = 0; pose < 160; pose += 2) validation.push_back(pose);
  TrainingSet set = task.set;
  set.validation = validation;
  TrainingPlan plan = plan_of(200);
  plan.batch = 40;
  Task kept;  // the validation poses alone
  for (const std::uint32_t pose : validation) {
    kept.features.insert(kept.features.end(), task.features.begin() + 5 * pose, task.features.begin() + 5 * pose + 5);
    kept.targets.insert(kept.targets.end(), task.targets.begin() + 3 * pose, task.targets.begin() + 3 * pose + 3);
  }
  kept.set = {validation.size(), 5, 3, kept.features, kept.targets};
  const TrainedLayers trained = train_layers(set, plan, silent_progress());
  REQUIRE(trained.epochs.size() == 200);
  double best = INFINITY;
  std::set<double> measured;
  for (const EpochLoss& epoch : trained.epochs)
    if (epoch.validation > 0) best = std::min(best, epoch.validation), measured.insert(epoch.validation);
  CHECK(measured.size() == 20);
  CHECK(relative_error(trained.layers, kept) == doctest::Approx(best).epsilon(1e-4));
  CHECK(trained.epochs.back().validation > 1.2 * best);
  CHECK(trained.epochs.back().training == trained.loss);

  // Targets of validation poses do not change the steps.
  const float before = task.targets[0];
  task.targets[0] = 1e6f;
  const TrainedLayers other = train_layers(set, plan, silent_progress());
  CHECK(other.epochs.front().training == trained.epochs.front().training);
  task.targets[0] = before;

  // An interrupted training keeps the best weights.
  const auto path = std::filesystem::temp_directory_path() / ("fb_trainer_" + std::to_string(getpid()));
  plan.checkpoint = path;
  StopAfter stop(300);
  CHECK_THROWS_AS(train_layers(set, plan, stop), Error);
  CHECK(same(trained.layers, train_layers(set, plan, silent_progress()).layers));
  std::filesystem::remove(path);

  std::vector<std::uint32_t> all(160);
  std::iota(all.begin(), all.end(), 0u);
  set.validation = all;
  CHECK_THROWS_AS(train_layers(set, plan, silent_progress()), Error);
}

TEST_CASE("training that diverges restarts at half the rate, three times at most") {
  const Task task = make_task(300, 1);
  TrainingPlan plan = plan_of(6);
  TrainedLayers trained;
  for (plan.learning_rate = 1; trained.restarts == 0; plan.learning_rate *= 4)
    trained = train_layers(task.set, plan, silent_progress());
  plan.learning_rate = std::ldexp(plan.learning_rate / 4, -static_cast<int>(trained.restarts));
  const TrainedLayers slower = train_layers(task.set, plan, silent_progress());
  CHECK(slower.restarts == 0);
  CHECK(same(slower.layers, trained.layers));
  plan.learning_rate = 1e15f;
  CHECK_THROWS_WITH_AS(train_layers(task.set, plan, silent_progress()), doctest::Contains("3 restarts"), Error);
}

TEST_CASE("training continues from given layers, also towards another network's outputs") {
  const Task task = make_task(1000, 1);
  TrainingPlan plan = plan_of(20);
  plan.output_scaling = 1;
  const TrainedLayers first = train_layers(task.set, plan, silent_progress());
  plan.initial_layers = first.layers;
  plan.epochs = 0;
  const std::vector<DenseLayer> untouched = train_layers(task.set, plan, silent_progress()).layers;
  CHECK(relative_error(untouched, task) == doctest::Approx(relative_error(first.layers, task)).epsilon(1e-4));
  plan.epochs = 20;
  const TrainedLayers more = train_layers(task.set, plan, silent_progress());
  CHECK(more.loss < 0.7 * first.loss);

  const std::vector<float> teacher_outputs = run_layers(more.layers, task.set, {});
  Task student = task;
  student.targets = teacher_outputs;
  student.set.targets = student.targets;
  CHECK(relative_error(train_layers(student.set, plan, silent_progress()).layers, student) <
        0.5 * relative_error(first.layers, student));

  plan.initial_layers.front().inputs = 4;
  CHECK_THROWS_AS(train_layers(task.set, plan, silent_progress()), Error);
}

TEST_CASE("every pose is trained on, also where batches leave some out, and features that are NaN stop training") {
  for (std::size_t pose = 0; pose < 5; ++pose) {
    Task task = make_task(5, 1);
    task.features[5 * pose] = NAN;
    TrainingPlan plan = plan_of(40);
    plan.batch = 3;
    CHECK_THROWS_WITH_AS(train_layers(task.set, plan, silent_progress()), doctest::Contains("not a number"), Error);
  }
}

TEST_CASE("the same seed gives the same network, whatever the threads; another seed another") {
  const Task task = make_task(700, 1);
  const auto layers = [&](const TrainingPlan& plan) { return train_layers(task.set, plan, silent_progress()).layers; };
  for (const bool bf16 : {false, true}) CHECK(same(layers(plan_of(3, 1, bf16)), layers(plan_of(3, 4, bf16))));
  TrainingPlan other = plan_of(3, 1);
  other.seed = 2;
  CHECK_FALSE(same(layers(plan_of(3, 1)), layers(other)));
}

TEST_CASE("an interrupted training resumes to the same network") {
  const auto path = std::filesystem::temp_directory_path() / ("fb_trainer_" + std::to_string(getpid()));
  const Task task = make_task(700, 1);
  TrainingPlan plan = plan_of(6);
  const auto whole = train_layers(task.set, plan, silent_progress()).layers;
  plan.checkpoint = path;
  StopAfter stop(7);
  CHECK_THROWS_AS(train_layers(task.set, plan, stop), Error);
  CHECK(std::filesystem::exists(path));
  CHECK(same(whole, train_layers(task.set, plan, silent_progress()).layers));
  std::filesystem::remove(path);
}

TEST_CASE("a checkpoint of other options or data is not resumed") {
  const auto path = std::filesystem::temp_directory_path() / ("fb_trainer_" + std::to_string(getpid()));
  const Task task = make_task(700, 1), other_task = make_task(700, 2);
  std::vector<TrainingPlan> others(10, plan_of(4));
  others[0].epochs = 3;
  others[1].seed = 2;
  others[2].batch = 128;
  others[3].learning_rate = 1e-3f;
  others[4].widths = {48, 48};
  others[5].activation = Activation::silu;
  others[6].output_scaling = 1;
  others[7].weight_decay = 0.1f;
  others[8].pose_balance = 1;
  others[9].microbatch = 64;
  const auto check_starts_fresh = [&](TrainingPlan plan, const TrainingSet& set) {
    const auto fresh = train_layers(set, plan, silent_progress()).layers;
    TrainingPlan first = plan_of(4);
    plan.checkpoint = first.checkpoint = path;
    StopAfter stop(2);
    CHECK_THROWS_AS(train_layers(task.set, first, stop), Error);
    CHECK(same(fresh, train_layers(set, plan, silent_progress()).layers));
  };
  for (const TrainingPlan& plan : others) check_starts_fresh(plan, task.set);
  check_starts_fresh(plan_of(4), other_task.set);
  std::filesystem::remove(path);
}

TEST_CASE("a checkpoint with another key, or a damaged one, is not loaded") {
  const auto path = std::filesystem::temp_directory_path() / ("fb_checkpoint_" + std::to_string(getpid()));
  save_checkpoint(path, {42, 7, {{1, 2, 3}, {4}}});
  const auto loaded = load_checkpoint(path, 42);
  REQUIRE(loaded);
  CHECK(loaded->step == 7);
  CHECK(loaded->arrays == std::vector<std::vector<float>>{{1, 2, 3}, {4}});
  CHECK_FALSE(load_checkpoint(path, 43));
  std::vector<std::byte> bytes = read_file(path);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::vector<std::byte> bad = bytes;
    bad[i] ^= std::byte{1};
    write_file(path, bad);
    CHECK_FALSE(load_checkpoint(path, 42));
    bad.resize(i);
    write_file(path, bad);
    CHECK_FALSE(load_checkpoint(path, 42));
  }
  std::filesystem::remove(path);
  CHECK_FALSE(load_checkpoint(path, 42));
}

TEST_CASE("run_layers computes the defined outputs, with gates and named columns") {
  const Task task = make_task(300, 1);
  TrainingPlan plan = plan_of(60);
  plan.activation = Activation::silu;
  const std::vector<DenseLayer> layers = train_layers(task.set, plan, silent_progress()).layers;
  std::vector<float> gates(300), wide(300 * 9, NAN);
  const std::vector<std::uint32_t> columns = {8, 0, 3, 2, 5};
  for (std::size_t i = 0; i < 300; ++i) {
    gates[i] = static_cast<float>(i % 5) / 4;
    for (std::size_t c = 0; c < 5; ++c) wide[9 * i + columns[c]] = task.features[5 * i + c];
  }
  TrainingSet set = task.set;
  set.gates = gates;
  set.targets = {};
  set.features = wide;
  set.stride = 9;
  set.columns = columns;
  Parallel one, two;
  one.threads = 1, two.threads = 2;
  const std::vector<float> got = run_layers(layers, set, two);
  CHECK(got == run_layers(layers, set, one));
  const float zero[5] = {};
  const std::vector<double> rest = outputs(layers, zero);
  double off = 0, size = 0;
  for (std::size_t i = 0; i < 300; ++i) {
    const std::vector<double> y = outputs(layers, task.features.data() + 5 * i);
    for (std::size_t k = 0; k < 3; ++k) {
      const double wanted = gates[i] * (y[k] - rest[k]);
      off = std::max(off, std::abs(got[3 * i + k] - wanted));
      size = std::max(size, std::abs(wanted));
    }
  }
  CHECK(size > 0.5);
  CHECK(off < 1e-5);
  // Training reads named columns alike.
  TrainingSet named = set;
  named.targets = task.targets;
  named.gates = {};
  CHECK(same(layers, train_layers(named, plan, silent_progress()).layers));
  named.columns = std::span(columns).first(4);
  CHECK_THROWS_AS(train_layers(named, plan, silent_progress()), Error);
  const std::vector<std::uint32_t> beyond = {8, 0, 3, 2, 9};
  named.columns = beyond;
  CHECK_THROWS_AS(train_layers(named, plan, silent_progress()), Error);
}

TEST_CASE("regions trained together are those trained one by one, whatever the threads") {
  const Task a = make_task(500, 1), b = make_task(300, 2), c = make_task(700, 3);
  const std::vector<TrainingSet> sets = {a.set, b.set, c.set};
  std::vector<TrainingPlan> plans = {plan_of(2), plan_of(3), plan_of(2)};
  plans[0].widths = {8};
  plans[1].activation = Activation::silu;
  plans[2].widths = {64, 64, 64, 64};  // costs more than the others together: gets all threads
  std::vector<std::vector<DenseLayer>> alone;
  for (std::size_t i = 0; i < 3; ++i) alone.push_back(train_layers(sets[i], plans[i], silent_progress()).layers);
  for (const int threads : {1, 2, 4}) {
    Parallel parallel;
    parallel.threads = threads;
    const std::vector<TrainedLayers> together = train_in_parallel(sets, plans, parallel, silent_progress());
    REQUIRE(together.size() == 3);
    for (std::size_t i = 0; i < 3; ++i) CHECK(same(alone[i], together[i].layers));
  }
  StopAfter stop(1);
  CHECK_THROWS_AS(train_in_parallel(sets, plans, {}, stop), Error);
  CHECK_THROWS_AS(train_in_parallel(sets, std::span(plans).first(2), {}, silent_progress()), Error);
}

TEST_CASE("an input whose scale is 0 is not learnt from, and scales fit the inputs") {
  Task task = make_task(300, 8);
  const std::vector<float> scales = {1, 1, 0, 1, 1};
  task.set.input_scales = scales;
  const std::vector<DenseLayer> layers = train_layers(task.set, plan_of(3), silent_progress()).layers;
  for (std::size_t o = 0; o < layers[0].outputs; ++o) CHECK(layers[0].weights[5 * o + 2] == 0);
  task.set.input_scales = std::span(scales).first(4);
  CHECK_THROWS_WITH(train_layers(task.set, plan_of(1), silent_progress()), doctest::Contains("4 scales for 5 inputs"));
}

TEST_CASE("features that do not fit the targets are refused") {
  Task task = make_task(10, 1);
  task.set.poses = 9;
  CHECK_THROWS_AS(train_layers(task.set, plan_of(1), silent_progress()), Error);
}

}  // namespace fb::bake::test_trainer
