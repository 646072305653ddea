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
