#include "bench/float_networks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/random_streams.h"

namespace fb::tool {

PaperNetwork::PaperNetwork(std::size_t controls, std::size_t vertices, std::uint64_t seed) {
  constexpr std::size_t depth = 8, width = 256, components = 200;
  Random random = open_stream(seed, Stream::bench_network);
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

FloatModel::FloatModel(const facebaker::Archive& archive, const facebaker::Model& model)
    : archive_(archive), model_(model), rows_(3 * std::size_t(model.vertex_count())) {
  const fb_archive_info info = archive.info();
  const std::uint32_t* direct = fb_archive_direct(archive.get());
  direct_.assign(direct, direct + info.direct_count);
  features_.resize(info.feature_count);
  coefficients_.resize(info.coefficient_count);
  std::size_t widest = 0;
  for (std::uint32_t r = 0; r < info.region_count; ++r) {
    regions_.push_back(read_region(r));
    for (const Layer& layer : regions_.back().layers)
      widest = std::max<std::size_t>({widest, layer.shape.inputs, layer.shape.outputs});
  }
  for (std::uint32_t b = 0; b < fb_row_block_count(model.get()); ++b) {
    row_blocks_.push_back(read_row_block(b));
    widest = std::max(widest, row_blocks_.back().columns.size());
  }
  x_.resize(widest);
  y_.resize(widest);
}

FloatModel::Region FloatModel::read_region(std::uint32_t index) const {
  const fb_region found = archive_.region(index);
  Region region{{found.inputs, found.inputs + found.input_count}, {}};
  for (std::uint32_t l = 0; l < found.layer_count; ++l) region.layers.push_back(read_layer(index, l));
  return region;
}

FloatModel::Layer FloatModel::read_layer(std::uint32_t region, std::uint32_t index) const {
  Layer layer{archive_.layer(region, index), {}, {}};
  const std::size_t inputs = layer.shape.inputs, outputs = layer.shape.outputs;
  std::vector<float> row_major(inputs * outputs);
  layer.bias.resize(outputs);
  facebaker::check(fb_archive_layer_values(archive_.get(), region, index, row_major.data(), layer.bias.data()));
  layer.weights.resize(inputs * outputs);
  for (std::size_t o = 0; o < outputs; ++o)
    for (std::size_t i = 0; i < inputs; ++i) layer.weights[i * outputs + o] = row_major[o * inputs + i];
  return layer;
}

FloatModel::RowBlock FloatModel::read_row_block(std::uint32_t index) const {
  fb_row_block shape;
  fb_row_block_init(&shape);
  facebaker::check(fb_row_block_at(model_.get(), index, &shape));
  RowBlock block{shape.first_row, shape.row_count, std::vector<std::uint32_t>(shape.column_count),
                 std::vector<float>(std::size_t(shape.row_count) * shape.column_count)};
  if (shape.column_count > 0)
    facebaker::check(fb_row_block_values(model_.get(), index, block.columns.data(), block.values.data()));
  return block;
}

float* FloatModel::run_region(const Region& region, float* coefficients) {
  const AffineKernels& kernels = affine_kernels();
  for (std::size_t i = 0; i < region.inputs.size(); ++i) x_[i] = features_[region.inputs[i]];
  for (const Layer& layer : region.layers) {
    const std::size_t outputs = layer.shape.outputs;
    kernels.multiply(outputs, layer.shape.inputs, 1, layer.weights.data(), layer.bias.data(), x_.data(), y_.data());
    const float* skipped = layer.shape.skip ? x_.data() : nullptr;
    if (layer.shape.activation == FB_ACTIVATION_RELU)
      kernels.rectify(outputs, skipped, y_.data());
    else if (layer.shape.activation != FB_ACTIVATION_LINEAR)  // tanh takes as long as silu
      kernels.silu(outputs, skipped, y_.data());
    x_.swap(y_);
  }
  return std::copy_n(x_.begin(), region.layers.back().shape.outputs, coefficients);
}

void FloatModel::evaluate(const float* controls, float* positions) {
  facebaker::check(fb_archive_features(archive_.get(), controls, features_.data()));
  float* coefficient = coefficients_.data();
  for (const std::uint32_t feature : direct_) *coefficient++ = features_[feature];
  for (const Region& region : regions_) coefficient = run_region(region, coefficient);
  for (const RowBlock& block : row_blocks_) {
    for (std::size_t c = 0; c < block.columns.size(); ++c) x_[c] = coefficients_[block.columns[c]];
    affine_kernels().multiply(block.row_count, block.columns.size(), 1, block.values.data(), nullptr, x_.data(),
                              rows_.data() + block.first_row);
  }
  const float* rest = model_.rest_positions();
  const std::uint32_t* order = fb_vertex_order(model_.get());
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const std::size_t coordinate = order ? 3 * std::size_t(order[row / 3]) + row % 3 : row;
    positions[coordinate] = rest[coordinate] + rows_[row];
  }
}

std::size_t FloatModel::bytes() const {
  std::size_t numbers = rows_.size();
  for (const Region& region : regions_)
    for (const Layer& layer : region.layers) numbers += layer.weights.size();
  for (const RowBlock& block : row_blocks_) numbers += block.values.size();
  return numbers * sizeof(float);
}

}  // namespace fb::tool
