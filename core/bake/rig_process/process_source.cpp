#include "bake/rig_process/process_source.h"

#include <algorithm>

#include "bake/rig/source_rules.h"
#include "base/shown_path.h"

namespace fb::bake {
namespace {

class ProcessBackend final : public EvaluationBackend {
 public:
  ProcessBackend(RigWorkers& workers, Progress* progress) : workers_(workers), progress_(progress) {}
  void evaluate_block(const EvaluationBlock& block) override { workers_.evaluate(block, progress_, evaluated_); }
  // Children can be killed at any time: blocks are interrupted at once.
  double block_seconds() const override { return 1; }
  std::size_t least_poses() const override {
    return workers_.count() * std::max<std::size_t>(workers_.description().preferred_block, 1);
  }

 private:
  RigWorkers& workers_;
  Progress* const progress_;
};

}  // namespace

ProcessSource::ProcessSource(RigCommand command, Progress* progress)
    : program_hash_(command.program_hash), workers_(std::move(command), progress), opening_(progress) {
  check_rest_pose(*this);
  opening_ = nullptr;
}

void ProcessSource::read(std::size_t clip, std::size_t first, std::size_t count, std::span<float> points) {
  evaluate_clip(*this, clip, first, count, points);
}

void ProcessSource::evaluate(std::span<const float> controls, std::size_t count, std::span<float> points) {
  std::vector<char> answered(count);
  ProcessBackend(workers_, opening_).evaluate_block({controls, count, points, answered});
}

std::size_t ProcessSource::preferred_block() const {
  const std::size_t of_one = workers_.description().preferred_block;
  return of_one == 0 && workers_.count() == 1 ? 0 : workers_.count() * std::max<std::size_t>(of_one, 1);
}

std::unique_ptr<EvaluationBackend> ProcessSource::make_backend(const Parallel& parallel) {
  return std::make_unique<ProcessBackend>(workers_, parallel.progress);
}

}  // namespace fb::bake
