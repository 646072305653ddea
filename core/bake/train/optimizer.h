// What a training step does apart from the gradient.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/train/dense_pass.h"
#include "bake/train/trainer.h"

namespace fb::bake {

// What the learning rate is multiplied with at `step` of `steps`.
double schedule_factor(Schedule schedule, std::uint64_t step, std::uint64_t steps);

// What the rate is multiplied with for each layer's weights.
std::vector<float> layer_rates(const NetShape& shape, const TrainingPlan& plan);

// Adam with decoupled weight decay (biases keep theirs): parameters and both moments.
struct Adam {
  std::vector<float> parameters, mean, square;

  explicit Adam(std::vector<float> start);
  // Step number `step`, from 0; gradients of the pieces of a batch, each as long as parameters, are added in order.
  // Weights shrink by rate * decay, whatever their layer's rate.
  void step(const NetShape& shape, std::uint64_t step, double rate, std::span<const float> layer_rates, double decay,
            const std::vector<const float*>& gradients, const Parallel& parallel);
};

// He's initialisation (for tanh LeCun's), times skip_start for layers that add to a skip; the last layer begins at 0:
// at first nothing moves.
std::vector<float> initial_parameters(const NetShape& shape, float skip_start, std::uint64_t seed);

// Parameters with weights rounded row by row as packing rounds them to `bits` bits; biases as they are.
void round_weights(const NetShape& shape, int bits, const std::vector<float>& parameters, std::vector<float>& rounded,
                   const Parallel& parallel);

}  // namespace fb::bake
