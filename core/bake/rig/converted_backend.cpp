#include "bake/rig/converted_backend.h"

#include <utility>
#include <vector>

namespace fb::bake {

ConvertedBackend::ConvertedBackend(std::unique_ptr<EvaluationBackend> backend, std::size_t floats, Convert convert)
    : backend_(std::move(backend)), floats_(floats), convert_(std::move(convert)) {}

void ConvertedBackend::evaluate_block(const EvaluationBlock& block) {
  const std::uint64_t before = backend_->evaluated();
  std::vector<float> points(block.count * floats_);
  const auto finish = [&] {
    evaluated_ += backend_->evaluated() - before;
    convert_(block.controls, points, block.count, block.points);
  };
  try {
    backend_->evaluate_block({block.controls, block.count, points, block.answered});
  } catch (...) {
    finish();
    throw;
  }
  finish();
}

}  // namespace fb::bake
