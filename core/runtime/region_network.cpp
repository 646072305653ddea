#include "runtime/region_network.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/status.h"

namespace fb::runtime {
namespace {

PanelMatrix digits_of(const PoseKernels& kernels, const PackedLayer& layer, PanelMatrix::Form form,
                      PanelMatrix::Digit digit, std::pmr::memory_resource& memory) {
  PanelMatrix digits(kernels, form, layer.outputs, layer.inputs, memory);
  for (std::uint32_t o = 0; o < layer.outputs; ++o)
    digits.set_row(o, layer.weights.data() + std::size_t(o) * layer.inputs, digit);
  digits.find_limit();
  return digits;
}

}  // namespace

RegionNetwork::Layer::Layer(const PoseKernels& kernels, const PackedLayer& layer, PanelMatrix::Form form,
                            std::pmr::memory_resource& memory)
    : inputs(layer.inputs),
      outputs(layer.outputs),
      activation(layer.activation),
      skip(layer.skip),
      low(digits_of(kernels, layer, form, {.high = false}, memory)),
      limit(static_cast<float>(low.limit())),
      scales(layer.scales.begin(), layer.scales.end(), &memory),
      bias(layer.bias.begin(), layer.bias.end(), &memory) {
  scales.resize(outputs + padding);
  bias.resize(outputs + padding);
  if (!layer.wide) return;
  high.emplace(digits_of(kernels, layer, form, {.high = true}, memory));
  limit = static_cast<float>(std::min(low.limit(), high->limit()));
}

// Rows of a wide layer, from the sums of both digits.
void RegionNetwork::Layer::join_digits(const PoseKernels& kernels, const QuantisedInputs& x, std::uint32_t first,
                                       float* const* rows) const {
  static constexpr float zeros[max_panel_rows] = {};
  float steps[poses_per_block], low_sums[poses_per_block][max_panel_rows], high_sums[poses_per_block][max_panel_rows];
  std::fill_n(steps, poses_per_block, 1.0f);
  for (const auto& [digits, sums] : {std::pair(&low, low_sums), std::pair(&*high, high_sums)}) {
    float* to[poses_per_block];
    for (std::size_t pose = 0; pose < x.poses; ++pose) to[pose] = sums[pose];
    digits->multiply(first, x.panel_inputs(), {nullptr, zeros, steps, to});
  }
  for (std::size_t pose = 0; pose < x.poses; ++pose)
    kernels.join_digits(low_sums[pose], high_sums[pose], scales.data() + first, x.steps[pose], bias.data() + first,
                        rows[pose], low.rows_at(first));
}

void RegionNetwork::Layer::run(const PoseKernels& kernels, const QuantisedInputs& x, std::size_t stride,
                               std::size_t count, const float* input, float* output) const {
  for (std::uint32_t first = 0; first < count; first += low.panel_rows()) {
    float* to[poses_per_block];
    for (std::size_t pose = 0; pose < x.poses; ++pose) to[pose] = output + pose * stride + first;
    if (high)
      join_digits(kernels, x, first, to);
    else
      low.multiply(first, x.panel_inputs(), {scales.data() + first, bias.data() + first, x.steps, to});
    for (std::size_t pose = 0; pose < x.poses; ++pose) kernels.activate(activation, to[pose], low.rows_at(first));
  }
  if (!skip) return;
  for (std::size_t pose = 0; pose < x.poses; ++pose)
    for (std::size_t o = 0; o < count; ++o) output[pose * stride + o] += input[pose * stride + o];
}

RegionNetwork::RegionNetwork(const PoseKernels& kernels, const PackedRegion& region, std::pmr::memory_resource& memory)
    : layers_(&memory), rest_outputs_(region.layers.back().outputs, &memory) {
  layers_.reserve(region.layers.size());
  for (const PackedLayer& layer : region.layers)
    layers_.emplace_back(kernels, layer, layers_.empty() ? PanelMatrix::Form::columns : PanelMatrix::Form::quads,
                         memory);
}

void RegionNetwork::copy_layer(std::size_t number, std::size_t stride, float* weights, float* bias) const {
  const Layer& layer = layers_[number];
  for (std::uint32_t o = 0; o < layer.outputs; ++o, weights += stride) {
    for (std::uint32_t i = 0; i < layer.inputs; ++i) {
      const int low = layer.low.digit(o, i), value = layer.high ? 256 * layer.high->digit(o, i) + low : low;
      weights[i] = layer.scales[o] * static_cast<float>(value);
    }
    bias[o] = layer.bias[o];
  }
}

std::size_t RegionNetwork::max_width() const {
  std::size_t width = 0;
  for (const Layer& layer : layers_) width = std::max<std::size_t>({width, layer.inputs, layer.outputs});
  return width;
}

void RegionNetwork::run(const PoseKernels& kernels, const MatrixInputs& input, std::size_t poses, std::size_t count,
                        float* work, QuantiseBuffers& buffers, float* outputs) const {
  const std::size_t stride = work_size();
  float *before = work, *after = work + stride / 2;
  if (layers_.front().skip)
    for (std::size_t pose = 0; pose < poses; ++pose) {
      std::fill_n(before + pose * stride, input_count(), 0.0f);
      for (std::size_t i = 0; i < input.count; ++i)
        before[pose * stride + layers_.front().low.column_at(input.offsets[i])] = input.values[i * poses + pose];
    }
  QuantisedInputs x;
  for (const Layer& layer : layers_) {
    const MatrixInputs dense = {before, layer.inputs, stride};
    quantise(kernels, &layer == &layers_.front() ? input : dense, layer.limit, poses, buffers.values(), buffers.row(),
             x);
    layer.run(kernels, x, stride, &layer == &layers_.back() ? count : layer.outputs, before, after);
    std::swap(before, after);
  }
  for (std::size_t pose = 0; pose < poses; ++pose)
    for (std::size_t o = 0; o < count; ++o) outputs[o * poses + pose] = before[pose * stride + o] - rest_outputs_[o];
}

void RegionNetwork::find_rest(const PoseKernels& kernels, const char* name, std::pmr::memory_resource& heap) {
  std::pmr::vector<float> work(work_size(), &heap), outputs(output_count(), &heap);
  QuantiseBuffers buffers(max_width(), 1, heap);
  std::fill(rest_outputs_.begin(), rest_outputs_.end(), 0.0f);
  run(kernels, {nullptr, 0}, 1, output_count(), work.data(), buffers, outputs.data());
  std::copy(outputs.begin(), outputs.end(), rest_outputs_.begin());
  if (!std::all_of(outputs.begin(), outputs.end(), [](float v) { return std::isfinite(v); }))
    fail(Status::corrupt, "region \"%s\" overflows in the rest pose", name);
}

}  // namespace fb::runtime
