#include "bake/train/dense_pass.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "bake/linalg/kernels.h"
#include "base/status.h"

namespace fb::bake {

NetworkShape::NetworkShape(std::size_t inputs, const TrainingPlan& plan, std::size_t outputs) {
  for (const std::uint32_t width : plan.widths) {
    layers.push_back({inputs, width, plan.activation, inputs == width && !layers.empty(), 0, 0});
    inputs = width;
  }
  layers.push_back({inputs, outputs, Activation::linear, false, 0, 0});
  assign_offsets();
}

NetworkShape::NetworkShape(const std::vector<DenseLayer>& dense) {
  for (const DenseLayer& layer : dense)
    layers.push_back({layer.inputs, layer.outputs, layer.activation, layer.skip, 0, 0});
  assign_offsets();
}

void NetworkShape::assign_offsets() {
  for (LayerShape& layer : layers) layer.weights = std::exchange(weights, weights + layer.inputs * layer.outputs);
  parameters = weights;
  for (LayerShape& layer : layers) layer.bias = std::exchange(parameters, parameters + layer.outputs);
}

std::vector<float> flatten_layers(const NetworkShape& shape, const std::vector<DenseLayer>& layers) {
  std::vector<float> parameters(shape.parameters);
  for (std::size_t l = 0; l < layers.size(); ++l) {
    std::ranges::copy(layers[l].weights, parameters.begin() + shape.layers[l].weights);
    std::ranges::copy(layers[l].bias, parameters.begin() + shape.layers[l].bias);
  }
  return parameters;
}

std::vector<DenseLayer> unflatten_layers(const NetworkShape& shape, const std::vector<float>& parameters) {
  std::vector<DenseLayer> layers;
  for (const LayerShape& layout : shape.layers) {
    DenseLayer layer{static_cast<std::uint32_t>(layout.inputs),
                     static_cast<std::uint32_t>(layout.outputs),
                     layout.activation,
                     layout.skip,
                     {},
                     {}};
    const auto weights = parameters.begin() + layout.weights, bias = parameters.begin() + layout.bias;
    layer.weights.assign(weights, weights + layout.inputs * layout.outputs);
    layer.bias.assign(bias, bias + layout.outputs);
    layers.push_back(std::move(layer));
  }
  return layers;
}

void check_features(const TrainingSet& set) {
  const std::size_t stride = set.stride ? set.stride : set.inputs;
  if (set.poses == 0 || set.features.size() != set.poses * stride ||
      (!set.gates.empty() && set.gates.size() != set.poses))
    fail(Status::invalid_argument, "training: %zu poses with %zu features and %zu gates", set.poses,
         set.features.size(), set.gates.size());
  if (set.columns.empty() ? stride < set.inputs : set.columns.size() != set.inputs)
    fail(Status::invalid_argument, "training: %zu columns and %zu features a pose for %zu inputs", set.columns.size(),
         stride, set.inputs);
  for (const std::uint32_t column : set.columns)
    if (column >= stride) fail(Status::invalid_argument, "training: column %u of %zu features", column, stride);
}

namespace {

void prefetch(const float* values, std::size_t count) {
  constexpr std::size_t line = 64 / sizeof(float);
  for (std::size_t i = 0; i < count; i += line) __builtin_prefetch(values + i);
}

}  // namespace

DensePass::DensePass(const NetworkShape& shape, bool bf16)
    : shape_(shape), bf16_(bf16), derivatives_(shape.layers.size()) {
  signals_.emplace_back(shape.layers.front().inputs * (max_poses + 1));
  for (const LayerShape& layer : shape.layers) signals_.emplace_back(layer.outputs * (max_poses + 1));
}

void DensePass::forward(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters,
                        bool keep_derivatives) {
  const Kernels& kernel = kernels();
  columns_ = poses.size() + 1;
  const std::size_t stride = set.stride ? set.stride : set.inputs;
  float* input = signals_[0].data();
  // Poses are in random order: their rows are fetched ahead, those of the targets for the errors afterwards.
  constexpr std::size_t ahead = 4;
  for (std::size_t p = 0; p < poses.size(); ++p) {
    if (set.columns.empty() && p + ahead < poses.size())
      prefetch(set.features.data() + poses[p + ahead] * stride, set.inputs);
    if (!set.targets.empty()) prefetch(set.targets.data() + poses[p] * set.outputs, set.outputs);
    const float* row = set.features.data() + poses[p] * stride;
    if (set.columns.empty()) std::copy_n(row, set.inputs, input);
    for (std::size_t i = 0; i < set.columns.size(); ++i) input[i] = row[set.columns[i]];
    input += set.inputs;
  }
  std::fill_n(input, set.inputs, 0.0f);

  for (std::size_t l = 0; l < shape_.layers.size(); ++l) {
    const LayerShape& layer = shape_.layers[l];
    const float* x = signals_[l].data();
    float* y = signals_[l + 1].data();
    const bool differentiate =
        keep_derivatives && l + 1 < shape_.layers.size();  // the last layer is linear in training
    if (differentiate) derivatives_[l].resize(signals_[l + 1].size());
    const auto multiply = bf16_ && keep_derivatives ? kernel.gemm_bf16 : kernel.gemm;
    multiply(Op::transposed, Op::plain, layer.outputs, columns_, layer.inputs, parameters + layer.weights, layer.inputs,
             x, layer.inputs, 0, y, layer.outputs);
    kernel.activation_forward(layer.activation, layer.outputs, columns_, parameters + layer.bias,
                              layer.skip ? x : nullptr, y, differentiate ? derivatives_[l].data() : nullptr);
  }

  float* y = signals_.back().data();
  const float* rest = y + poses.size() * set.outputs;
  for (const std::uint32_t pose : poses) {
    const float gate = set.gates.empty() ? 1.0f : set.gates[pose];
    for (std::size_t k = 0; k < set.outputs; ++k) y[k] = (y[k] - rest[k]) * gate;
    y += set.outputs;
  }
}

std::span<const float> DensePass::outputs(const TrainingSet& set, std::span<const std::uint32_t> poses,
                                          const float* parameters) {
  forward(set, poses, parameters, false);
  return std::span(signals_.back()).first(poses.size() * set.outputs);
}

// Replaces the outputs by the errors of coefficients; returns the sum of their squares.
double DensePass::coefficient_errors(const TrainingSet& set, std::span<const std::uint32_t> poses,
                                     const LossWeights& weights) {
  std::vector<float> squares(set.outputs);  // one sum a coefficient, so that the loop vectorises
  float* error = signals_.back().data();
  for (const std::uint32_t pose : poses) {
    const float* target = set.targets.data() + pose * set.outputs;
    for (std::size_t k = 0; k < set.outputs; ++k) {
      error[k] = error[k] * weights.output_scale[k] - target[k];
      squares[k] += error[k] * error[k];
    }
    error += set.outputs;
  }
  double sum = 0;
  for (const float square : squares) sum += square;
  return sum;
}

double DensePass::loss(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters,
                       const LossWeights& weights) {
  forward(set, poses, parameters, false);
  return coefficient_errors(set, poses, weights);
}

double DensePass::loss_and_gradient(const TrainingSet& set, std::span<const std::uint32_t> poses,
                                    const float* parameters, const LossWeights& weights, float scale) {
  forward(set, poses, parameters, true);
  const double sum = coefficient_errors(set, poses, weights);

  if (output_gradient_.empty()) {
    gradient_.resize(shape_.parameters);
    for (const auto& signal : signals_) output_gradient_.resize(std::max(output_gradient_.size(), signal.size()));
    input_gradient_.resize(output_gradient_.size());
  }
  const std::size_t outputs = set.outputs;
  const float* error = signals_.back().data();
  float* output_gradient = output_gradient_.data();
  float* rest_gradient = output_gradient + poses.size() * outputs;
  std::fill_n(rest_gradient, outputs, 0.0f);
  for (const std::uint32_t pose : poses) {
    float factor = 2 * scale;
    if (!weights.pose_weight.empty()) factor *= weights.pose_weight[pose];
    if (!set.gates.empty()) factor *= set.gates[pose];
    for (std::size_t k = 0; k < outputs; ++k) {
      output_gradient[k] = factor * weights.output_weight[k] * weights.output_scale[k] * error[k];
      rest_gradient[k] -= output_gradient[k];
    }
    output_gradient += outputs;
    error += outputs;
  }
  for (std::size_t l = shape_.layers.size(); l-- > 0;) backward(l, parameters);
  return sum;
}

// Backpropagates through one layer: output_gradient_ becomes the gradient of the layer's inputs.
void DensePass::backward(std::size_t l, const float* parameters) {
  const Kernels& kernel = kernels();
  const auto multiply = bf16_ ? kernel.gemm_bf16 : kernel.gemm;
  const LayerShape& layer = shape_.layers[l];
  float* bias = gradient_.data() + layer.bias;
  std::fill_n(bias, layer.outputs, 0.0f);
  // The last layer's bias cancels against the rest pose, so its gradient is 0.
  if (l + 1 < shape_.layers.size())
    kernel.activation_backward(layer.outputs, columns_, derivatives_[l].data(), output_gradient_.data(),
                               layer.skip ? input_gradient_.data() : nullptr, bias);
  multiply(Op::plain, Op::transposed, layer.inputs, layer.outputs, columns_, signals_[l].data(), layer.inputs,
           output_gradient_.data(), layer.outputs, 0, gradient_.data() + layer.weights, layer.inputs);
  if (l == 0) return;
  // With a residual connection, this adds to the copy of the output gradient.
  multiply(Op::plain, Op::plain, layer.inputs, columns_, layer.outputs, parameters + layer.weights, layer.inputs,
           output_gradient_.data(), layer.outputs, layer.skip ? 1.0f : 0.0f, input_gradient_.data(), layer.inputs);
  std::swap(output_gradient_, input_gradient_);
}

std::vector<float> run_layers(const std::vector<DenseLayer>& layers, const TrainingSet& set, const Parallel& parallel) {
  check_features(set);
  if (layers.empty() || layers.front().inputs != set.inputs || layers.back().outputs != set.outputs)
    fail(Status::invalid_argument, "running layers: they do not take %zu inputs to %zu outputs", set.inputs,
         set.outputs);
  const NetworkShape shape(layers);
  const std::vector<float> parameters = flatten_layers(shape, layers);
  std::vector<DensePass> passes(worker_count(parallel), DensePass(shape));
  std::vector<float> outputs(set.poses * set.outputs);
  constexpr std::size_t microbatch = DensePass::max_poses;
  parallel_for(parallel, (set.poses + microbatch - 1) / microbatch, [&](std::size_t m, std::size_t worker) {
    std::vector<std::uint32_t> poses(std::min(microbatch, set.poses - m * microbatch));
    std::iota(poses.begin(), poses.end(), static_cast<std::uint32_t>(m * microbatch));
    std::ranges::copy(passes[worker].outputs(set, poses, parameters.data()),
                      outputs.begin() + m * microbatch * set.outputs);
  });
  return outputs;
}

}  // namespace fb::bake
