#include "bake/train/dense_pass.h"

#include <algorithm>
#include <utility>

#include "bake/linalg/kernels.h"
#include "base/status.h"

namespace fb::bake {

NetShape::NetShape(std::size_t inputs, const TrainingPlan& plan, std::size_t outputs) {
  for (const std::uint32_t width : plan.widths) {
    layers.push_back({inputs, width, plan.activation, inputs == width && !layers.empty(), 0, 0});
    inputs = width;
  }
  layers.push_back({inputs, outputs, Activation::linear, false, 0, 0});
  place();
}

NetShape::NetShape(const std::vector<DenseLayer>& dense) {
  for (const DenseLayer& layer : dense)
    layers.push_back({layer.inputs, layer.outputs, layer.activation, layer.skip, 0, 0});
  place();
}

void NetShape::place() {
  for (LayerShape& layer : layers) layer.weights = std::exchange(weights, weights + layer.inputs * layer.outputs);
  parameters = weights;
  for (LayerShape& layer : layers) layer.bias = std::exchange(parameters, parameters + layer.outputs);
}

std::vector<float> parameters_of(const NetShape& shape, const std::vector<DenseLayer>& layers) {
  std::vector<float> parameters(shape.parameters);
  for (std::size_t l = 0; l < layers.size(); ++l) {
    std::ranges::copy(layers[l].weights, parameters.begin() + shape.layers[l].weights);
    std::ranges::copy(layers[l].bias, parameters.begin() + shape.layers[l].bias);
  }
  return parameters;
}

std::vector<DenseLayer> layers_of(const NetShape& shape, const std::vector<float>& parameters) {
  std::vector<DenseLayer> layers;
  for (const LayerShape& at : shape.layers) {
    DenseLayer layer{
        static_cast<std::uint32_t>(at.inputs), static_cast<std::uint32_t>(at.outputs), at.activation, at.skip, {}, {}};
    const auto weights = parameters.begin() + at.weights, bias = parameters.begin() + at.bias;
    layer.weights.assign(weights, weights + at.inputs * at.outputs);
    layer.bias.assign(bias, bias + at.outputs);
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
    fail(Status::invalid_argument, "training: %zu columns named and %zu features a pose for %zu inputs",
         set.columns.size(), stride, set.inputs);
  for (const std::uint32_t column : set.columns)
    if (column >= stride) fail(Status::invalid_argument, "training: column %u of %zu features", column, stride);
}

DensePass::DensePass(const NetShape& shape) : shape_(shape), slopes_(shape.layers.size()) {
  signals_.emplace_back(shape.layers.front().inputs * (most_poses + 1));
  for (const LayerShape& layer : shape.layers) signals_.emplace_back(layer.outputs * (most_poses + 1));
}

void DensePass::forward(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters,
                        bool learns) {
  const Kernels& on = kernels();
  columns_ = poses.size() + 1;
  const std::size_t stride = set.stride ? set.stride : set.inputs;
  float* input = signals_[0].data();
  for (const std::uint32_t pose : poses) {
    const float* row = set.features.data() + pose * stride;
    if (set.columns.empty()) std::copy_n(row, set.inputs, input);
    for (std::size_t i = 0; i < set.columns.size(); ++i) input[i] = row[set.columns[i]];
    input += set.inputs;
  }
  std::fill_n(input, set.inputs, 0.0f);

  for (std::size_t l = 0; l < shape_.layers.size(); ++l) {
    const LayerShape& layer = shape_.layers[l];
    const float* x = signals_[l].data();
    float* y = signals_[l + 1].data();
    const bool bends = learns && l + 1 < shape_.layers.size();  // the last layer is linear when it learns
    if (bends) slopes_[l].resize(signals_[l + 1].size());
    on.multiply(Op::transposed, Op::plain, layer.outputs, columns_, layer.inputs, parameters + layer.weights,
                layer.inputs, x, layer.inputs, 0, y, layer.outputs);
    on.activate(layer.activation, layer.outputs, columns_, parameters + layer.bias, layer.skip ? x : nullptr, y,
                bends ? slopes_[l].data() : nullptr);
  }

  float* y = signals_.back().data();
  const float* rest = y + poses.size() * set.outputs;
  for (const std::uint32_t pose : poses) {
    const float gate = set.gates.empty() ? 1.0f : set.gates[pose];
    for (std::size_t k = 0; k < set.outputs; ++k) y[k] = (y[k] - rest[k]) * gate;
    y += set.outputs;
  }
}

std::span<const float> DensePass::run(const TrainingSet& set, std::span<const std::uint32_t> poses,
                                      const float* parameters) {
  forward(set, poses, parameters, false);
  return std::span(signals_.back()).first(poses.size() * set.outputs);
}

// Leaves the errors of coefficients in place of the outputs.
double DensePass::errors(const TrainingSet& set, std::span<const std::uint32_t> poses, const LossScale& scales) {
  std::vector<float> squares(set.outputs);  // one sum a coefficient: sums side by side are what vectors do
  float* error = signals_.back().data();
  for (const std::uint32_t pose : poses) {
    const float* target = set.targets.data() + pose * set.outputs;
    for (std::size_t k = 0; k < set.outputs; ++k) {
      error[k] = error[k] * scales.unit[k] - target[k];
      squares[k] += error[k] * error[k];
    }
    error += set.outputs;
  }
  double sum = 0;
  for (const float square : squares) sum += square;
  return sum;
}

double DensePass::test(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters,
                       const LossScale& scales) {
  forward(set, poses, parameters, false);
  return errors(set, poses, scales);
}

double DensePass::learn(const TrainingSet& set, std::span<const std::uint32_t> poses, const float* parameters,
                        const LossScale& scales, float scale) {
  forward(set, poses, parameters, true);
  const double sum = errors(set, poses, scales);

  if (down_.empty()) {
    gradient_.resize(shape_.parameters);
    for (const auto& signal : signals_) down_.resize(std::max(down_.size(), signal.size()));
    up_.resize(down_.size());
  }
  const std::size_t outputs = set.outputs;
  const float* error = signals_.back().data();
  float* down = down_.data();
  float* rest = down + poses.size() * outputs;
  std::fill_n(rest, outputs, 0.0f);
  for (const std::uint32_t pose : poses) {
    float twice = 2 * scale;
    if (!scales.pose_weight.empty()) twice *= scales.pose_weight[pose];
    if (!set.gates.empty()) twice *= set.gates[pose];
    for (std::size_t k = 0; k < outputs; ++k) {
      down[k] = twice * scales.weight[k] * scales.unit[k] * error[k];
      rest[k] -= down[k];
    }
    down += outputs;
    error += outputs;
  }
  for (std::size_t l = shape_.layers.size(); l-- > 0;) backward(l, parameters);
  return sum;
}

// Takes the gradient of the layer's outputs in down_ and leaves that of its inputs there.
void DensePass::backward(std::size_t l, const float* parameters) {
  const Kernels& on = kernels();
  const LayerShape& layer = shape_.layers[l];
  float* bias = gradient_.data() + layer.bias;
  std::fill_n(bias, layer.outputs, 0.0f);
  // The last layer's bias cancels against the rest pose and stays 0.
  if (l + 1 < shape_.layers.size())
    on.backward(layer.outputs, columns_, slopes_[l].data(), down_.data(), layer.skip ? up_.data() : nullptr, bias);
  on.multiply(Op::plain, Op::transposed, layer.inputs, layer.outputs, columns_, signals_[l].data(), layer.inputs,
              down_.data(), layer.outputs, 0, gradient_.data() + layer.weights, layer.inputs);
  if (l == 0) return;
  // With a skip the inputs' gradient is added to the copy of the outputs' in up_.
  on.multiply(Op::plain, Op::plain, layer.inputs, columns_, layer.outputs, parameters + layer.weights, layer.inputs,
              down_.data(), layer.outputs, layer.skip ? 1.0f : 0.0f, up_.data(), layer.inputs);
  std::swap(down_, up_);
}

}  // namespace fb::bake
