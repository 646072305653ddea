#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "bake/analysis/live/evaluation_cache.h"
#include "bake/analysis/rig_analysis.h"
#include "bake/rig/source.h"
#include "base/parallel.h"
#include "base/progress.h"

namespace fb::bake {

// Asks a live rig for many poses in blocks, so that no more than a block of displacements is ever held, and counts.
class RigEvaluator {
 public:
  using Fill = std::function<void(std::size_t pose, std::span<float> controls)>;  // controls are the rest pose before
  using Visit = std::function<void(std::size_t pose, std::span<const float> controls, std::span<float> displacement)>;

  // Within options.rig_budget; answers of a slow rig are kept in options.answers.
  RigEvaluator(Source& rig, const AnalysisOptions& options, const Parallel& parallel, Progress& progress);

  // A stage of `count` poses begins, which are then asked for in one or more calls.
  void begin(std::string_view stage, std::size_t count);
  // Calls fill for every pose below count, asks the rig, and calls visit for each, several at once: visit writes to
  // what belongs to its pose only. Fails by what was asked if a pose cannot be evaluated. count is within left().
  void ask(std::size_t count, const Fill& fill, const Visit& visit);

  const RigSchema& schema() const { return rig_->schema(); }
  const std::vector<float>& rest() const { return rest_; }  // pose
  std::size_t size() const { return rig_->rest().points.size(); }
  double diagonal() const { return diagonal_; }
  const Parallel& parallel() const { return parallel_; }
  Progress& progress() const { return *progress_; }
  std::uint64_t calls() const { return calls_; }
  std::uint64_t left() const { return budget_ ? budget_ - calls_ : UINT64_MAX; }

 private:
  // Points of `count` poses, from the log or the rig.
  void answer(std::span<const float> controls, std::size_t count, std::span<float> points);

  Source* rig_;
  std::optional<EvaluationCache> log_;
  std::uint64_t budget_, calls_ = 0, done_ = 0;  // done_: of the stage
  Parallel parallel_;
  Progress* progress_;
  std::vector<float> rest_;
  double diagonal_;
};

}  // namespace fb::bake
