#include "bench/float_networks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/random.h"
#include "model/feature_values.h"

namespace fb::tool {

PaperNetwork::PaperNetwork(std::size_t controls, std::size_t vertices, std::uint64_t seed) {
  constexpr std::size_t depth = 8, width = 256, components = 200;
  Random random(seed);
  const auto add = [&](std::size_t inputs, std::size_t outputs) {
    Layer layer{inputs, outputs, std::vector<float>(inputs * outputs), std::vector<float>(outputs)};
    const float reach = std::sqrt(3 / float(inputs));
    for (float& weight : layer.weights) weight = random.uniform(-reach, reach);
    layers_.push_back(std::move(layer));
  };
  for (std::size_t d = 0; d < depth; ++d) add(d == 0 ? controls : width, width);
  add(width, components);
  add(components, 3 * vertices);
}

void PaperNetwork::evaluate(std::size_t poses, const float* controls, float* positions) {
  const AffineKernels& kernels = affine_kernels();
  const std::size_t hidden = layers_.size() - 2;
  x_.resize(poses * 256);
  y_.resize(poses * 256);
  const float* input = controls;
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const Layer& layer = layers_[l];
    float* output = l + 1 < layers_.size() ? y_.data() : positions;
    kernels.multiply(layer.outputs, layer.inputs, poses, layer.weights.data(), layer.bias.data(), input, output);
    if (l < hidden) kernels.rectify(poses * layer.outputs, l > 0 ? input : nullptr, output);
    x_.swap(y_);
    input = x_.data();
  }
}

std::size_t PaperNetwork::bytes() const {
  std::size_t numbers = 0;
  for (const Layer& layer : layers_) numbers += layer.weights.size() + layer.bias.size();
  return numbers * sizeof(float);
}

FloatModel::FloatModel(const PackedModel& model)
    : model_(model),
      rest_controls_(model.schema.rest_pose()),
      features_(model.features.size()),
      coefficients_(model.columns),
      rows_(model.rest.points.size()) {
  std::size_t widest = 0;
  for (const PackedRegion& region : model.regions) {
    auto& layers = layers_.emplace_back();
    for (const PackedLayer& layer : region.layers) {
      std::vector<float>& weights = layers.emplace_back(layer.weights.size());
      for (std::size_t o = 0; o < layer.outputs; ++o)
        for (std::size_t i = 0; i < layer.inputs; ++i)
          weights[i * layer.outputs + o] = layer.scales[o] * layer.weights[o * layer.inputs + i];
      widest = std::max<std::size_t>({widest, layer.inputs, layer.outputs});
    }
  }
  for (const PackedRowBlock& group : model.row_blocks) {
    std::vector<float>& values = groups_.emplace_back();
    for (std::size_t c = 0; c < group.columns.size(); ++c) {
      const std::vector<float> moved = displacements(group, c);
      values.insert(values.end(), moved.begin(), moved.end());
    }
    widest = std::max(widest, group.columns.size());
  }
  x_.resize(widest);
  y_.resize(widest);
}

void FloatModel::evaluate(const float* controls, float* positions) {
  const AffineKernels& kernels = affine_kernels();
  feature_values(model_.features, controls, rest_controls_.data(), features_.data());
  float* coefficient = coefficients_.data();
  for (const std::uint32_t feature : model_.direct) *coefficient++ = features_[feature];
  for (std::size_t r = 0; r < model_.regions.size(); ++r) {
    const PackedRegion& region = model_.regions[r];
    for (std::size_t i = 0; i < region.features.size(); ++i) x_[i] = features_[region.features[i]];
    for (std::size_t l = 0; l < region.layers.size(); ++l) {
      const PackedLayer& layer = region.layers[l];
      kernels.multiply(layer.outputs, layer.inputs, 1, layers_[r][l].data(), layer.bias.data(), x_.data(), y_.data());
      const float* skipped = layer.skip ? x_.data() : nullptr;
      if (layer.activation == Activation::relu)
        kernels.rectify(layer.outputs, skipped, y_.data());
      else if (layer.activation != Activation::linear)  // tanh takes as long
        kernels.silu(layer.outputs, skipped, y_.data());
      x_.swap(y_);
    }
    coefficient = std::copy_n(x_.begin(), region.layers.back().outputs, coefficient);
  }
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const PackedRowBlock& group = model_.row_blocks[g];
    for (std::size_t c = 0; c < group.columns.size(); ++c) x_[c] = coefficients_[group.columns[c].column];
    kernels.multiply(group.row_count, group.columns.size(), 1, groups_[g].data(), nullptr, x_.data(),
                     rows_.data() + group.first_row);
  }
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const std::size_t at = model_.coordinate(static_cast<std::uint32_t>(row));
    positions[at] = model_.rest.points[at] + rows_[row];
  }
}

std::size_t FloatModel::bytes() const {
  std::size_t numbers = rows_.size();
  for (const auto& layers : layers_)
    for (const auto& weights : layers) numbers += weights.size();
  for (const auto& values : groups_) numbers += values.size();
  return numbers * sizeof(float);
}

}  // namespace fb::tool
