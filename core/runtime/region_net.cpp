#include "runtime/region_net.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/status.h"

namespace fb {
namespace {

PanelMatrix digits_of(const PackedLayer& layer, bool high, std::pmr::memory_resource& memory) {
  const auto write_column = [&](std::size_t input, std::int16_t* digits) {
    const std::int16_t* weight = layer.weights.data() + input;
    for (std::uint32_t o = 0; o < layer.outputs; ++o, weight += layer.inputs)
      digits[o] = static_cast<std::int16_t>(high ? high_digit(*weight) : layer.wide ? low_digit(*weight) : *weight);
  };
  return PanelMatrix(layer.outputs, layer.inputs, write_column, memory);
}

}  // namespace

RegionNet::Layer::Layer(const PackedLayer& layer, std::pmr::memory_resource& memory)
    : inputs(layer.inputs),
      outputs(layer.outputs),
      activation(layer.activation),
      skip(layer.skip),
      low(digits_of(layer, false, memory)),
      limit(static_cast<float>(low.limit())),
      scales(layer.scales.begin(), layer.scales.end(), &memory),
      bias(layer.bias.begin(), layer.bias.end(), &memory) {
  if (!layer.wide) return;
  high.emplace(digits_of(layer, true, memory));
  limit = static_cast<float>(std::min(low.limit(), high->limit()));
}

void RegionNet::Layer::run(const PoseKernels& kernels, const Quantized& x, const float* input, float* output) const {
  for (std::uint32_t first = 0; first < outputs; first += PanelMatrix::panel_rows) {
    std::int32_t low_sums[PanelMatrix::panel_rows], high_sums[PanelMatrix::panel_rows];
    low.sum(kernels, first, x.columns(), low_sums);
    if (high) high->sum(kernels, first, x.columns(), high_sums);
    kernels.finish_layer(low_sums, high ? high_sums : nullptr, scales.data() + first, x.step(), bias.data() + first,
                         activation, output + first, low.rows_at(first));
  }
  if (skip)
    for (std::uint32_t o = 0; o < outputs; ++o) output[o] += input[o];
}

RegionNet::RegionNet(const PackedRegion& region, std::pmr::memory_resource& memory)
    : layers_(&memory), at_rest_(region.layers.back().outputs, &memory) {
  layers_.reserve(region.layers.size());
  for (const PackedLayer& layer : region.layers) layers_.emplace_back(layer, memory);
}

std::size_t RegionNet::widest() const {
  std::size_t widest = 0;
  for (const Layer& layer : layers_) widest = std::max<std::size_t>({widest, layer.inputs, layer.outputs});
  return widest;
}

[[gnu::noinline]] void RegionNet::run(const PoseKernels& kernels, const NetInput& input, float* work,
                                      Quantized& quantized, float* outputs) const {
  float *before = work, *after = work + work_size() / 2;
  quantized.quantize(kernels, input.values, input.places, input.count, layers_.front().limit);
  if (layers_.front().skip) {
    std::fill_n(before, input_count(), 0.0f);
    for (std::size_t i = 0; i < input.count; ++i) before[input.places[i]] = input.values[i];
  }
  for (const Layer& layer : layers_) {
    if (&layer != &layers_.front()) quantized.quantize(kernels, before, nullptr, layer.inputs, layer.limit);
    layer.run(kernels, quantized, before, after);
    std::swap(before, after);
  }
  for (std::size_t o = 0; o < output_count(); ++o) outputs[o] = before[o] - at_rest_[o];
}

void RegionNet::find_rest(const PoseKernels& kernels, const char* name) {
  std::vector<float> work(work_size()), outputs(output_count());
  Quantized quantized(widest(), *std::pmr::get_default_resource());
  std::fill(at_rest_.begin(), at_rest_.end(), 0.0f);
  run(kernels, {nullptr, nullptr, 0}, work.data(), quantized, outputs.data());
  std::copy(outputs.begin(), outputs.end(), at_rest_.begin());
  if (!std::all_of(outputs.begin(), outputs.end(), [](float v) { return std::isfinite(v); }))
    fail(Status::not_finite, "region \"%s\" overflows in the rest pose", name);
}

}  // namespace fb
