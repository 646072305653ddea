#include "bake/train/optimiser.h"

#include <algorithm>
#include <cmath>

#include "bake/linalg/kernels.h"
#include "base/random_streams.h"

namespace fb::bake {

double schedule_factor(Schedule schedule, std::uint64_t step, std::uint64_t steps) {
  constexpr double pi = 3.14159265358979323846;
  const double progress = static_cast<double>(step) / static_cast<double>(steps);
  if (schedule == Schedule::cosine) return 0.5 * (1 + std::cos(pi * progress));
  const double warmup_steps = 0.03 * static_cast<double>(steps), done = static_cast<double>(step) + 1;
  return std::min({1.0, warmup_steps > 1 ? done / warmup_steps : 1.0, 2 * (1 - progress)});
}

Adam::Adam(std::vector<float> initial_parameters)
    : parameters(std::move(initial_parameters)), mean(parameters.size()), square(mean) {}

std::vector<float> layer_rate_factors(const NetworkShape& shape, const TrainingPlan& plan) {
  std::vector<float> factors(shape.layers.size(), plan.hidden_rate_factor);
  factors.front() = 1;
  factors.back() = plan.output_rate_factor;
  return factors;
}

void Adam::step(const NetworkShape& shape, std::uint64_t step, double rate, const RateFactors& factors, double decay,
                const std::vector<const float*>& gradients, const Parallel& parallel) {
  constexpr float beta1 = 0.9f, beta2 = 0.999f, epsilon = 1e-8f;
  const float correction1 = 1 - std::pow(beta1, static_cast<float>(step + 1));
  const float correction2 = 1 - std::pow(beta2, static_cast<float>(step + 1));
  const AdamStep adam{static_cast<float>(rate) / correction1, 1 / std::sqrt(correction2), beta1, beta2, epsilon, 1};
  const auto update = [&](AdamStep scaled, float rate_factor, std::size_t first, std::size_t count) {
    scaled.step_size *= rate_factor;
    kernels().adam(scaled, first, count, gradients.data(), gradients.size(), parameters.data(), mean.data(),
                   square.data());
  };
  AdamStep with_decay = adam;
  with_decay.decay_factor = static_cast<float>(1 - rate * decay);
  parallel_for(parallel, shape.layers.size(), [&](std::size_t l, std::size_t) {
    const LayerShape& layer = shape.layers[l];
    const std::span weights = std::span(parameters).subspan(layer.weights, layer.inputs * layer.outputs);
    const bool by_input = l == 0 && !factors.inputs.empty();
    const std::vector<float> before(weights.begin(), by_input ? weights.end() : weights.begin());
    update(with_decay, factors.layers[l], layer.weights, weights.size());
    for (std::size_t i = 0; i < before.size(); ++i) {
      const float factor = factors.inputs[i % layer.inputs], decayed = with_decay.decay_factor * before[i];
      weights[i] = decayed + factor * (weights[i] - decayed);
    }
    update(adam, 1, layer.bias, layer.outputs);
  });
}

std::vector<float> initial_parameters(const NetworkShape& shape, float residual_init_scale,
                                      std::span<const float> input_scales, std::uint64_t seed) {
  std::vector<float> parameters(shape.parameters);
  for (std::size_t l = 0; l + 1 < shape.layers.size(); ++l) {
    const LayerShape& layer = shape.layers[l];
    Random random = open_stream(seed, Stream::network_weights, l);
    const float gain = layer.activation == Activation::tanh ? 1.0f : 2.0f;
    const float deviation = std::sqrt(gain / layer.inputs) * (layer.skip ? residual_init_scale : 1.0f);
    for (std::size_t i = 0; i < layer.inputs * layer.outputs; ++i)
      parameters[layer.weights + i] =
          deviation * random.normal() * (l == 0 && !input_scales.empty() ? input_scales[i % layer.inputs] : 1.0f);
  }
  return parameters;
}

void quantise_weights(const NetworkShape& shape, int bits, const std::vector<float>& parameters,
                      std::vector<float>& quantised, const Parallel& parallel) {
  const float levels = static_cast<float>((1 << (bits - 1)) - 1);
  quantised.resize(shape.parameters);
  parallel_for(parallel, shape.layers.size(), [&](std::size_t l, std::size_t) {
    const LayerShape& layer = shape.layers[l];
    for (std::size_t o = 0; o < layer.outputs; ++o) {
      const std::size_t row = layer.weights + o * layer.inputs;
      kernels().quantise_row(layer.inputs, levels, parameters.data() + row, quantised.data() + row);
    }
  });
  std::copy(parameters.begin() + shape.weights, parameters.end(), quantised.begin() + shape.weights);
}

}  // namespace fb::bake
