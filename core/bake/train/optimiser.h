// The optimiser: learning-rate schedule, initialisation, Adam and quantisation of weights.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bake/train/dense_pass.h"
#include "bake/train/trainer.h"

namespace fb::bake {

// Factor on the learning rate at `step` of `steps`.
double schedule_factor(Schedule schedule, std::uint64_t step, std::uint64_t steps);

// Factor on the learning rate of each layer's weights.
std::vector<float> layer_rate_factors(const NetworkShape& shape, const TrainingPlan& plan);

// Factors on the learning rate: of each layer's weights, and of the first layer's weights from each input (empty: 1).
struct RateFactors {
  std::span<const float> layers, inputs;
};

// Adam with decoupled weight decay (of weights, not of biases): parameters and both moments.
struct Adam {
  std::vector<float> parameters, mean, square;

  explicit Adam(std::vector<float> initial_parameters);
  // Step number `step`, from 0. `gradients`: of the microbatches, each as long as parameters, summed in order. Weights
  // decay by rate * decay, whatever their rate factor.
  void step(const NetworkShape& shape, std::uint64_t step, double rate, const RateFactors& factors, double decay,
            const std::vector<const float*>& gradients, const Parallel& parallel);
};

// He's initialisation (LeCun's for tanh), times residual_init_scale for layers with a residual connection. The output
// layer starts at 0. With input_scales, the first layer's weights are multiplied by that of their input.
std::vector<float> initial_parameters(const NetworkShape& shape, float residual_init_scale,
                                      std::span<const float> input_scales, std::uint64_t seed);

// Parameters with weights quantised to `bits` bits row by row as packing does; biases stay.
void quantise_weights(const NetworkShape& shape, int bits, const std::vector<float>& parameters,
                      std::vector<float>& quantised, const Parallel& parallel);

}  // namespace fb::bake
