#pragma once

#include <functional>
#include <memory>
#include <span>

#include "bake/rig/evaluation_backend.h"

namespace fb::bake {

// What another backend evaluates, converted: for a source that gives the poses of another one otherwise.
class ConvertedBackend final : public EvaluationBackend {
 public:
  // Writes points of poses from those of the other source.
  using Convert = std::function<void(std::span<const float> controls, std::span<const float> from, std::size_t poses,
                                     std::span<float> to)>;

  // floats: of a pose of the other source.
  ConvertedBackend(std::unique_ptr<EvaluationBackend> backend, std::size_t floats, Convert convert);
  void evaluate_block(const EvaluationBlock& block) override;
  double block_seconds() const override { return backend_->block_seconds(); }
  std::size_t least_poses() const override { return backend_->least_poses(); }

 private:
  const std::unique_ptr<EvaluationBackend> backend_;
  const std::size_t floats_;
  const Convert convert_;
};

}  // namespace fb::bake
