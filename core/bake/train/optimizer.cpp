#include "bake/train/optimizer.h"

#include <algorithm>
#include <cmath>

#include "bake/linalg/kernels.h"
#include "base/random.h"

namespace fb::bake {

double schedule_factor(Schedule schedule, std::uint64_t step, std::uint64_t steps) {
  constexpr double pi = 3.14159265358979323846;
  const double at = static_cast<double>(step) / static_cast<double>(steps);
  if (schedule == Schedule::cosine) return 0.5 * (1 + std::cos(pi * at));
  const double rise = 0.03 * static_cast<double>(steps), risen = static_cast<double>(step) + 1;
  return std::min({1.0, rise > 1 ? risen / rise : 1.0, 2 * (1 - at)});
}

Adam::Adam(std::vector<float> start) : parameters(std::move(start)), mean(parameters.size()), square(mean) {}

std::vector<float> layer_rates(const NetShape& shape, const TrainingPlan& plan) {
  std::vector<float> rates(shape.layers.size(), plan.hidden_rate);
  rates.front() = 1;
  rates.back() = plan.last_rate;
  return rates;
}

void Adam::step(const NetShape& shape, std::uint64_t step, double rate, std::span<const float> layer_rates,
                double decay, const std::vector<const float*>& gradients, const Parallel& parallel) {
  constexpr float beta1 = 0.9f, beta2 = 0.999f, epsilon = 1e-8f;
  const float correction1 = 1 - std::pow(beta1, static_cast<float>(step + 1));
  const float correction2 = 1 - std::pow(beta2, static_cast<float>(step + 1));
  const AdamStep adam{static_cast<float>(rate) / correction1, 1 / std::sqrt(correction2), beta1, beta2, epsilon, 1};
  const auto run = [&](AdamStep own, float layer_rate, std::size_t first, std::size_t count) {
    own.rate *= layer_rate;
    kernels().adam(own, first, count, gradients.data(), gradients.size(), parameters.data(), mean.data(),
                   square.data());
  };
  AdamStep decaying = adam;
  decaying.decay = static_cast<float>(1 - rate * decay);
  parallel_for(parallel, shape.layers.size(), [&](std::size_t l, std::size_t) {
    const LayerShape& layer = shape.layers[l];
    run(decaying, layer_rates[l], layer.weights, layer.inputs * layer.outputs);
    run(adam, 1, layer.bias, layer.outputs);
  });
}

std::vector<float> initial_parameters(const NetShape& shape, float skip_start, std::uint64_t seed) {
  std::vector<float> parameters(shape.parameters);
  for (std::size_t l = 0; l + 1 < shape.layers.size(); ++l) {
    const LayerShape& layer = shape.layers[l];
    Random random(seed, l);
    const float gain = layer.activation == Activation::tanh ? 1.0f : 2.0f;
    const float deviation = std::sqrt(gain / layer.inputs) * (layer.skip ? skip_start : 1.0f);
    for (std::size_t i = 0; i < layer.inputs * layer.outputs; ++i)
      parameters[layer.weights + i] = deviation * random.normal();
  }
  return parameters;
}

void round_weights(const NetShape& shape, int bits, const std::vector<float>& parameters, std::vector<float>& rounded,
                   const Parallel& parallel) {
  const float levels = static_cast<float>((1 << (bits - 1)) - 1);
  rounded.resize(shape.parameters);
  parallel_for(parallel, shape.layers.size(), [&](std::size_t l, std::size_t) {
    const LayerShape& layer = shape.layers[l];
    for (std::size_t o = 0; o < layer.outputs; ++o) {
      const std::size_t row = layer.weights + o * layer.inputs;
      kernels().round_row(layer.inputs, levels, parameters.data() + row, rounded.data() + row);
    }
  });
  std::copy(parameters.begin() + shape.weights, parameters.end(), rounded.begin() + shape.weights);
}

}  // namespace fb::bake
