#include <algorithm>
#include <mutex>
#include <numeric>

#include "bake/train/dense_pass.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// What a network costs, in any unit: numbers touched over its training.
double cost_of(const TrainingSet& set, const TrainingPlan& plan) {
  const NetShape shape = plan.start.empty() ? NetShape(set.inputs, plan, set.outputs) : NetShape(plan.start);
  return static_cast<double>(shape.parameters) * static_cast<double>(set.poses) * plan.epochs;
}

// One bar for trainings that run beside each other.
class SharedProgress {
 public:
  static constexpr std::uint64_t total = 10000;

  SharedProgress(Progress& progress, std::string_view stage) : progress_(progress) { progress.begin(stage, total); }

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

// One training's part of the bar.
class PartProgress final : public Progress {
 public:
  PartProgress(SharedProgress& whole, double share) : whole_(whole), share_(share) {}
  void begin(std::string_view, std::uint64_t total) override { total_ = total; }
  void update(std::uint64_t done) override {
    const double at = static_cast<double>(done) / static_cast<double>(std::max<std::uint64_t>(total_, 1));
    whole_.add((at - at_) * share_);
    at_ = at;
  }
  bool cancelled() const override { return whole_.cancelled(); }
  void note(std::string_view sentence) override { whole_.note(sentence); }

 private:
  SharedProgress& whole_;
  double share_, at_ = 0;
  std::uint64_t total_ = 0;
};

// How long trainings, the longest first, take at least when each runs on a thread of its own.
double time_of(std::span<const double> costs, std::size_t workers) {
  if (costs.empty()) return 0;
  return std::max(costs.front(), std::accumulate(costs.begin(), costs.end(), 0.0) / static_cast<double>(workers));
}

// How many of the trainings, the longest first, are quicker one after another on all threads.
std::size_t count_alone(std::span<const double> costs, std::size_t workers, std::size_t microbatches) {
  std::size_t alone = 0;
  const double speedup = static_cast<double>(std::min(workers, microbatches));
  while (alone < costs.size() && workers > 1 &&
         costs[alone] / speedup + time_of(costs.subspan(alone + 1), workers) < time_of(costs.subspan(alone), workers))
    ++alone;
  return alone;
}

}  // namespace

std::vector<TrainedLayers> train_regions(std::span<const TrainingSet> sets, std::span<const TrainingPlan> plans,
                                         const Parallel& parallel, Progress& progress, std::string_view stage) {
  if (sets.size() != plans.size())
    fail(Status::invalid_argument, "training: %zu plans for %zu networks", plans.size(), sets.size());
  std::vector<std::size_t> order(sets.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<double> costs(sets.size());
  for (std::size_t i = 0; i < sets.size(); ++i) costs[i] = cost_of(sets[i], plans[i]);
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return costs[a] > costs[b]; });
  std::ranges::sort(costs, std::greater<>());
  const double all = std::max(std::accumulate(costs.begin(), costs.end(), 0.0), 1.0);

  SharedProgress shared(progress, stage);
  std::vector<TrainedLayers> trained(sets.size());
  const auto train = [&](std::size_t place, const Parallel& own) {
    TrainingPlan plan = plans[order[place]];
    plan.parallel = own;
    PartProgress part(shared, costs[place] / all);
    trained[order[place]] = train_layers(sets[order[place]], plan, part);
  };
  const std::size_t microbatches =
      sets.empty() ? 1 : (plans[order[0]].batch + plans[order[0]].microbatch - 1) / plans[order[0]].microbatch;
  const std::size_t alone = count_alone(costs, worker_count(parallel), microbatches);
  for (std::size_t place = 0; place < alone; ++place) train(place, parallel);
  Parallel serial;
  serial.threads = 1;
  parallel_for(parallel, sets.size() - alone, [&](std::size_t index, std::size_t) { train(alone + index, serial); });
  return trained;
}

}  // namespace fb::bake
