#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "bake/rig/source.h"
#include "base/parallel.h"

namespace fb::bake {

// Poses to evaluate at once.
struct EvaluationBlock {
  std::span<const float> controls;  // count x controls
  std::size_t count;
  std::span<float> points;   // count x 3 x vertices
  std::span<char> answered;  // count flags, 0 before: which poses have their points
};

// Evaluates blocks of poses for a RigEvaluator, which does everything else: counting, budgets, cache. Threads of this
// process are one backend, child processes another, and a function of the host, for other machines, a third.
class EvaluationBackend {
 public:
  virtual ~EvaluationBackend() = default;
  // Fills the points of all poses of a block, which do not depend on how the work is spread. What a rig depends on
  // (files, a licence server) may fail now and then: poses that fail are evaluated once more. Then throws PoseError for
  // the first of them, numbered within the block; or Error(interrupted). Poses that are flagged as answered by then
  // have their points.
  virtual void evaluate_block(const EvaluationBlock& block) = 0;
  // How long a block may take where somebody wants to be able to interrupt between two of them.
  virtual double block_seconds() const { return 0.2; }
  // Poses that keep all of the backend at work; blocks should not be smaller.
  virtual std::size_t least_poses() const = 0;
  // Poses evaluated so far, failed ones and those evaluated once more included.
  std::uint64_t evaluated() const { return evaluated_; }

 protected:
  std::atomic<std::uint64_t> evaluated_{0};
};

// Calls a source in pieces of the block, on several threads if it is thread-safe.
class ThreadBackend final : public EvaluationBackend {
 public:
  // `source` must outlive this.
  ThreadBackend(Source& source, const Parallel& parallel);
  void evaluate_block(const EvaluationBlock& block) override;
  std::size_t least_poses() const override;

 private:
  void evaluate_piece(const EvaluationBlock& block, std::size_t first, std::size_t poses);

  Source& source_;
  Parallel parallel_;
};

}  // namespace fb::bake
