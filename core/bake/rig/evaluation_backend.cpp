#include "bake/rig/evaluation_backend.h"

#include <algorithm>

namespace fb::bake {

ThreadBackend::ThreadBackend(Source& source, const Parallel& parallel) : source_(source), parallel_(parallel) {
  if (!source.thread_safe()) parallel_.threads = 1;
}

std::size_t ThreadBackend::least_poses() const {
  const std::size_t preferred = source_.preferred_block();
  return preferred > 0 ? preferred * worker_count(parallel_) : 1;
}

void ThreadBackend::evaluate_block(const EvaluationBlock& block) {
  // Few poses of a slow rig are spread too. Pieces do not depend on the number of threads.
  const std::size_t preferred = source_.preferred_block(),
                    piece = preferred > 0 ? preferred : std::clamp<std::size_t>(block.count / 8, 1, 32);
  parallel_for(parallel_, (block.count + piece - 1) / piece, [&](std::size_t index, std::size_t) {
    evaluate_piece(block, index * piece, std::min(piece, block.count - index * piece));
  });
}

void ThreadBackend::evaluate_piece(const EvaluationBlock& block, std::size_t first, std::size_t poses) {
  const std::size_t width = source_.schema().control_count(), size = source_.rest().points.size();
  for (bool again = false;; again = true) {
    evaluated_ += poses;
    try {
      source_.evaluate(block.controls.subspan(first * width, poses * width), poses,
                       block.points.subspan(first * size, poses * size));
      break;
    } catch (const PoseError& error) {
      if (again || error.status() == Status::invalid_argument)
        throw PoseError(error.status(), first + error.pose(), error.reason());
    }
  }
  std::ranges::fill(block.answered.subspan(first, poses), 1);
}

}  // namespace fb::bake
