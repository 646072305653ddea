#include "bake/train/trainer.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "bake/train/checkpoint.h"
#include "base/file.h"
#include "base/random.h"
#include "base/status.h"

using namespace fb;

namespace {

struct Task {
  std::vector<float> features, targets;
  TrainingSet set;
};

// Products and ramps of five numbers.
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

// What a reader of the archive computes, in double.
std::vector<double> outputs(const std::vector<DenseLayer>& layers, const float* input) {
  std::vector<double> x(input, input + layers[0].inputs);
  for (const DenseLayer& layer : layers) {
    std::vector<double> y(layer.outputs);
    for (std::size_t o = 0; o < layer.outputs; ++o) {
      double sum = layer.bias[o];
      for (std::size_t i = 0; i < layer.inputs; ++i) sum += double(layer.weights[o * layer.inputs + i]) * x[i];
      if (layer.activation == Activation::relu) sum = std::max(sum, 0.0);
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

TrainingPlan plan_of(std::uint32_t epochs, int threads = 0) {
  TrainingPlan plan;
  plan.widths = {48, 48, 48};
  plan.learning_rate = 3e-3f;
  plan.epochs = epochs;
  plan.parallel.threads = threads;
  return plan;
}

// What is trained, by definition: the mean over all poses of |outputs - outputs at rest - targets / size|^2.
double loss_of(const std::vector<DenseLayer>& layers, const Task& task, double size) {
  const float zero[5] = {};
  const std::vector<double> rest = outputs(layers, zero);
  double sum = 0;
  for (std::size_t i = 0; i < task.set.poses; ++i) {
    const std::vector<double> y = outputs(layers, task.features.data() + 5 * i);
    for (std::size_t k = 0; k < 3; ++k) sum += std::pow(y[k] - rest[k] - task.targets[3 * i + k] / size, 2);
  }
  return sum / double(task.set.poses);
}

// Every number that is trained: weights, and the biases of all layers but the last.
std::vector<float*> numbers_of(std::vector<DenseLayer>& layers) {
  std::vector<float*> numbers;
  for (DenseLayer& layer : layers) {
    for (float& weight : layer.weights) numbers.push_back(&weight);
    if (&layer != &layers.back())
      for (float& bias : layer.bias) numbers.push_back(&bias);
  }
  return numbers;
}

bool same(const std::vector<DenseLayer>& a, const std::vector<DenseLayer>& b) {
  for (std::size_t l = 0; l < a.size(); ++l)
    if (a[l].weights != b[l].weights || a[l].bias != b[l].bias) return false;
  return a.size() == b.size();
}

struct StopAfter final : Progress {
  explicit StopAfter(std::uint64_t steps) : steps(steps) {}
  void begin(std::string_view, std::uint64_t) override {}
  void update(std::uint64_t done) override { stopped = done >= steps; }
  bool cancelled() const override { return stopped; }
  void note(std::string_view) override {}
  std::uint64_t steps;
  bool stopped = false;
};

}  // namespace

TEST_CASE("training learns products and ramps of poses it has not seen") {
  const Task task = make_task(4000, 1), unseen = make_task(500, 2);
  const TrainedLayers trained = train_layers(task.set, plan_of(40), silent_progress());
  CHECK(trained.layers.size() == 4);
  CHECK_FALSE(trained.layers[0].skip);
  CHECK(trained.layers[1].skip);
  CHECK(trained.layers[3].activation == Activation::linear);
  CHECK(trained.loss < 0.01);
  CHECK(relative_error(trained.layers, unseen) < 0.01);
  CHECK(relative_error(trained.layers, task) == doctest::Approx(trained.loss).epsilon(0.5));
}

TEST_CASE("steps are those of Adam on the gradient of the loss, along half a cosine") {
  const Task task = make_task(200, 5);  // fewer than a batch, so that each step sees all
  double squares = 0;
  for (const float target : task.targets) squares += double(target) * target;
  const double size = std::sqrt(squares / double(task.targets.size()));
  TrainingPlan plan = plan_of(0);
  plan.widths = {8, 8, 8};
  const std::vector<DenseLayer> start = train_layers(task.set, plan, silent_progress()).layers;
  std::vector<DenseLayer> layers = start;
  const std::vector<float*> numbers = numbers_of(layers);
  std::vector<double> mean(numbers.size()), square(numbers.size());
  constexpr int steps = 5;
  for (int step = 0; step < steps; ++step) {
    const double here = loss_of(layers, task, size);
    std::vector<double> gradient;
    for (float* number : numbers) {  // downwards, as a ReLU that is just at 0 has no slope
      const float kept = *number;
      *number = kept - 1e-4f;
      gradient.push_back((here - loss_of(layers, task, size)) / (double(kept) - *number));
      *number = kept;
    }
    const double rate = 3e-3 * 0.5 * (1 + std::cos(M_PI * step / steps));
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      mean[i] = 0.9 * mean[i] + 0.1 * gradient[i];
      square[i] = 0.999 * square[i] + 0.001 * gradient[i] * gradient[i];
      const double m = mean[i] / (1 - std::pow(0.9, step + 1)), v = square[i] / (1 - std::pow(0.999, step + 1));
      *numbers[i] -= static_cast<float>(rate * m / (std::sqrt(v) + 1e-8));
    }
  }
  plan.epochs = steps;
  std::vector<DenseLayer> trained = train_layers(task.set, plan, silent_progress()).layers;
  for (float& weight : trained.back().weights) weight = static_cast<float>(weight / size);
  const std::vector<float*> got = numbers_of(trained);
  std::vector<DenseLayer> first = start;
  const std::vector<float*> before = numbers_of(first);
  double off = 0, moved = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    off += std::abs(double(*got[i]) - *numbers[i]);
    moved += std::abs(double(*got[i]) - *before[i]);
  }
  CHECK(moved > 0.1);
  CHECK(off < 0.02 * moved);
  CHECK(trained.back().bias == std::vector<float>(3));
}

TEST_CASE("every pose is trained on, also where batches leave some out, and numbers that are none stop it") {
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
  const auto one = train_layers(task.set, plan_of(3, 1), silent_progress()).layers;
  CHECK(same(one, train_layers(task.set, plan_of(3, 4), silent_progress()).layers));
  TrainingPlan other = plan_of(3, 1);
  other.seed = 2;
  CHECK_FALSE(same(one, train_layers(task.set, other, silent_progress()).layers));
}

TEST_CASE("an interrupted training goes on to the very same network") {
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

TEST_CASE("a training that differs in anything begins anew") {
  const auto path = std::filesystem::temp_directory_path() / ("fb_trainer_" + std::to_string(getpid()));
  const Task task = make_task(700, 1), other_task = make_task(700, 2);
  std::vector<TrainingPlan> others(5, plan_of(4));
  others[0].epochs = 3;
  others[1].seed = 2;
  others[2].batch = 128;
  others[3].learning_rate = 1e-3f;
  others[4].widths = {48, 48};
  const auto begun_after_another = [&](TrainingPlan plan, const TrainingSet& set) {
    const auto fresh = train_layers(set, plan, silent_progress()).layers;
    TrainingPlan first = plan_of(4);
    plan.checkpoint = first.checkpoint = path;
    StopAfter stop(2);
    CHECK_THROWS_AS(train_layers(task.set, first, stop), Error);
    CHECK(same(fresh, train_layers(set, plan, silent_progress()).layers));
  };
  for (const TrainingPlan& plan : others) begun_after_another(plan, task.set);
  begun_after_another(plan_of(4), other_task.set);
  std::filesystem::remove(path);
}

TEST_CASE("a checkpoint of other work, or a damaged one, is left alone") {
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

TEST_CASE("features that do not fit the targets are refused") {
  Task task = make_task(10, 1);
  task.set.poses = 9;
  CHECK_THROWS_AS(train_layers(task.set, plan_of(1), silent_progress()), Error);
}
