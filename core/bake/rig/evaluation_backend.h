#pragma once

#include <cstddef>
#include <span>

#include "bake/rig/source.h"
#include "base/parallel.h"

namespace fb::bake {

// Evaluates blocks of poses for a RigEvaluator, which does everything else: counting, budgets, cache, retries. Threads
// of this process are one backend; child processes or ranks of other machines would be others.
class EvaluationBackend {
 public:
  virtual ~EvaluationBackend() = default;
  // Points of `count` poses in their order (count x controls -> count x 3 x vertices). The points do not depend on how
  // the work is spread. Throws PoseError for the first pose that fails, numbered within the block.
  virtual void evaluate_block(std::span<const float> controls, std::size_t count, std::span<float> points) = 0;
};

// Calls a source in pieces of the block, on several threads if it is thread-safe.
class ThreadBackend final : public EvaluationBackend {
 public:
  // `source` must outlive this.
  ThreadBackend(Source& source, const Parallel& parallel);
  void evaluate_block(std::span<const float> controls, std::size_t count, std::span<float> points) override;

 private:
  Source& source_;
  Parallel parallel_;
};

}  // namespace fb::bake
