// A network small enough to compare sets of training poses with: it learns, at evenly spaced vertices, the residual of
// a sum of single-control curves.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/rig/rig_evaluator.h"
#include "bake/train/trainer.h"

namespace fb::bench {
using namespace fb::bake;

struct QuickErrors {
  double mse = 0, max = 0, mfm = 0;  // as core/bake/measure defines them, at the sampled vertices
};

class QuickMethod {
 public:
  // Evaluates five values of each control.
  QuickMethod(RigEvaluator& rig, std::size_t vertices);

  // Rig minus curves in these poses: poses x 3 x sampled vertices, over the diagonal.
  std::vector<float> residuals_of(std::span<const float> controls) const;
  std::vector<DenseLayer> train(std::span<const float> controls, std::span<const float> residuals,
                                const TrainingPlan& plan) const;
  std::vector<float> predict(const std::vector<DenseLayer>& layers, std::span<const float> controls) const;
  QuickErrors errors(std::span<const float> predicted, std::span<const float> residuals) const;

  std::size_t width() const { return width_; }
  std::size_t outputs() const { return 3 * vertices_.size(); }

 private:
  std::vector<float> features(std::span<const float> controls) const;
  std::vector<float> displacements(std::span<const float> controls) const;

  RigEvaluator& rig_;
  std::size_t width_;
  std::vector<std::size_t> vertices_;
  std::vector<float> curves_;  // controls x values x outputs
};

}  // namespace fb::bench
