#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/train/trainer.h"

namespace fb::bake {

// Scaling and weights of the loss, see TrainingPlan::output_scaling and pose_balance.
struct LossWeights {
  std::vector<float> output_scale;   // coefficient = output_scale * output of the last layer
  std::vector<float> output_weight;  // of a coefficient's squared error
  std::vector<float> pose_weight;    // of a pose's squared errors; empty: 1
};

// Sum of the squared targets of these poses, and in `squares` that of each coefficient.
double sum_of_squares(const TrainingSet& set, std::span<const std::uint32_t> poses, std::vector<double>& squares);

// The loss weights for training on `poses` of the set. `squares` and `total`: from sum_of_squares of these poses.
LossWeights loss_weights(const TrainingSet& set, std::span<const std::uint32_t> poses, const TrainingPlan& plan,
                         const std::vector<double>& squares, double total);

}  // namespace fb::bake
