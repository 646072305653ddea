#include <algorithm>
#include <mutex>
#include <numeric>

#include "bake/train/dense_pass.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// The relative cost of a training: parameters x poses x epochs.
double training_cost(const TrainingSet& set, const TrainingPlan& plan) {
  const NetworkShape shape =
      plan.initial_layers.empty() ? NetworkShape(set.inputs, plan, set.outputs) : NetworkShape(plan.initial_layers);
  return static_cast<double>(shape.parameters) * static_cast<double>(set.poses) * plan.epochs;
}

// One progress bar for trainings that run in parallel. Thread-safe.
class SharedProgress {
 public:
  static constexpr std::uint64_t total = 10000;

  SharedProgress(Progress& progress, std::string_view stage) : progress_(progress) {
    progress.begin(Phase::training, stage, total);
  }

  bool cancelled() const { return progress_.cancelled(); }
  void note(std::string_view sentence) {
    const std::lock_guard lock(mutex_);
    progress_.note(sentence);
  }
  void add(double share) {
    const std::lock_guard lock(mutex_);
    done_ += share;
    progress_.update(static_cast<std::uint64_t>(std::clamp(done_, 0.0, 1.0) * total));
  }

 private:
  Progress& progress_;
  std::mutex mutex_;
  double done_ = 0;
};

// One training's share of the bar.
class PartProgress final : public Progress {
 public:
  PartProgress(SharedProgress& whole, double share) : whole_(whole), share_(share) {}
  void begin(Phase, std::string_view, std::uint64_t total) override { total_ = total; }
  void update(std::uint64_t done) override {
    const double fraction = static_cast<double>(done) / static_cast<double>(std::max<std::uint64_t>(total_, 1));
    whole_.add((fraction - fraction_) * share_);
    fraction_ = fraction;
  }
  bool cancelled() const override { return whole_.cancelled(); }
  void note(std::string_view sentence) override { whole_.note(sentence); }

 private:
  SharedProgress& whole_;
  double share_, fraction_ = 0;
  std::uint64_t total_ = 0;
};

// Lower bound of the time of trainings, longest first, that run in parallel with one thread each.
double parallel_time(std::span<const double> costs, std::size_t workers) {
  if (costs.empty()) return 0;
  return std::max(costs.front(), std::accumulate(costs.begin(), costs.end(), 0.0) / static_cast<double>(workers));
}

// How many of the trainings, longest first, finish sooner one after another with all threads each.
std::size_t count_sequential(std::span<const double> costs, std::size_t workers, std::size_t microbatches) {
  std::size_t sequential = 0;
  const double speedup = static_cast<double>(std::min(workers, microbatches));
  while (sequential < costs.size() && workers > 1 &&
         costs[sequential] / speedup + parallel_time(costs.subspan(sequential + 1), workers) <
             parallel_time(costs.subspan(sequential), workers))
    ++sequential;
  return sequential;
}

}  // namespace

std::vector<TrainedLayers> train_in_parallel(std::span<const TrainingSet> sets, std::span<const TrainingPlan> plans,
                                             const Parallel& parallel, Progress& progress, std::string_view stage) {
  if (sets.size() != plans.size())
    fail(Status::invalid_argument, "training: %zu plans for %zu networks", plans.size(), sets.size());
  std::vector<std::size_t> order(sets.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<double> costs(sets.size());
  for (std::size_t i = 0; i < sets.size(); ++i) costs[i] = training_cost(sets[i], plans[i]);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return costs[a] > costs[b]; });
  std::ranges::sort(costs, std::greater<>());
  const double total = std::max(std::accumulate(costs.begin(), costs.end(), 0.0), 1.0);

  SharedProgress shared(progress, stage);
  std::vector<TrainedLayers> trained(sets.size());
  const auto train = [&](std::size_t rank, const Parallel& threads) {
    TrainingPlan plan = plans[order[rank]];
    plan.parallel = threads;
    PartProgress part(shared, costs[rank] / total);
    trained[order[rank]] = train_layers(sets[order[rank]], plan, part);
  };
  const std::size_t microbatches =
      sets.empty() ? 1 : (plans[order[0]].batch + plans[order[0]].microbatch - 1) / plans[order[0]].microbatch;
  const std::size_t sequential = count_sequential(costs, worker_count(parallel), microbatches);
  for (std::size_t rank = 0; rank < sequential; ++rank) train(rank, parallel);
  Parallel serial;
  serial.threads = 1;
  parallel_for(parallel, sets.size() - sequential,
               [&](std::size_t index, std::size_t) { train(sequential + index, serial); });
  return trained;
}

}  // namespace fb::bake
