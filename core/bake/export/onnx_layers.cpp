#include "bake/export/onnx_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "bake/export/onnx_rounding.h"

namespace fb::bake {
namespace {

// Weights as digits, inputs x outputs; `low` only of 16-bit weights.
struct LayerDigits {
  std::vector<float> high, low;
  float limit = 0;

  explicit LayerDigits(const PackedLayer& layer) {
    const std::size_t inputs = layer.inputs, outputs = layer.outputs;
    high.resize(inputs * outputs);
    if (layer.wide) low.resize(inputs * outputs);
    std::uint64_t largest = 0;
    for (std::size_t o = 0; o < outputs; ++o) {
      std::uint64_t high_sum = 0, low_sum = 0;
      for (std::size_t i = 0; i < inputs; ++i) {
        const int weight = layer.weights[o * inputs + i], upper = layer.wide ? high_digit(weight) : weight;
        high[i * outputs + o] = static_cast<float>(upper);
        high_sum += static_cast<std::uint64_t>(std::abs(upper));
        if (!layer.wide) continue;
        low[i * outputs + o] = static_cast<float>(low_digit(weight));
        low_sum += static_cast<std::uint64_t>(std::abs(low_digit(weight)));
      }
      largest = std::max({largest, high_sum, low_sum});
    }
    limit = rounding_limit(largest);
  }
};

// rational_tanh() of activation.h, whose numbers these are: ONNX' Tanh is not its equal to the last bits, and inputs of
// the next layer that round the other way show.
std::string add_tanh(OnnxGraph& graph, const std::string& label, const std::string& y) {
  static constexpr std::array p = {-2.76076847742355e-16f, 2.00018790482477e-13f, -8.60467152213735e-11f,
                                   5.12229709037114e-08f,  1.48572235717979e-05f, 6.37261928875436e-04f,
                                   4.89352455891786e-03f};
  static constexpr std::array q = {1.19825839466702e-06f, 1.18534705686654e-04f, 2.26843463243900e-03f,
                                   4.89352518554385e-03f};
  constexpr float end = 7.90531110763549805f;
  const std::string x = graph.node("Clip", label, {y, graph.number(label, -end), graph.number(label, end)});
  const std::string s = graph.node("Mul", label, {x, x});
  const std::string upper = graph.node("Mul", label, {x, graph.polynomial(label, s, p)});
  return graph.node("Div", label, {upper, graph.polynomial(label, s, q)});
}

std::string add_activation(OnnxGraph& graph, const std::string& label, Activation activation, const std::string& y) {
  if (activation == Activation::relu) return graph.node("Relu", label, {y});
  if (activation == Activation::tanh) return add_tanh(graph, label, y);
  if (activation == Activation::linear) return y;
  const std::string half = graph.number(label, 0.5f);
  const std::string turned = add_tanh(graph, label, graph.node("Mul", label, {half, y}));
  const std::string share = graph.node("Add", label, {half, graph.node("Mul", label, {half, turned})});
  return graph.node("Mul", label, {y, share});
}

std::string add_layer(OnnxGraph& graph, const std::string& label, const PackedLayer& layer, const std::string& x,
                      std::uint64_t& parameters) {
  const LayerDigits digits(layer);
  const auto outputs = static_cast<std::int64_t>(layer.outputs);
  parameters += digits.high.size() + digits.low.size() + 2 * layer.bias.size();
  const RoundedInputs inputs = round_inputs(graph, label, x, digits.limit);
  std::string sums = digit_sums(graph, label, inputs, digits.high, layer.outputs);
  if (layer.wide) {
    const std::string upper = graph.node("Mul", label, {sums, graph.number(label, 256)});
    sums = graph.node("Add", label, {upper, digit_sums(graph, label, inputs, digits.low, layer.outputs)});
  }
  const std::string scale =
      graph.node("Mul", label, {graph.floats(label + "/scales", layer.scales, {1, outputs}), inputs.step});
  std::string y = graph.node("Mul", label, {scale, sums});
  y = graph.node("Add", label, {y, graph.floats(label + "/bias", layer.bias, {1, outputs})});
  y = add_activation(graph, label, layer.activation, y);
  return layer.skip ? graph.node("Add", label, {y, x}) : y;
}

float activated(Activation activation, float y) {
  switch (activation) {
    case Activation::relu:
      return std::max(y, 0.0f);
    case Activation::tanh:
      return rational_tanh(y);
    case Activation::silu:
      return rational_silu(y);
    case Activation::linear:
      break;
  }
  return y;
}

// One row of outputs of a layer.
std::vector<float> evaluate_layer(const PackedLayer& layer, const std::vector<float>& x) {
  const float limit = LayerDigits(layer).limit;
  float largest = 0;
  for (const float value : x) largest = std::max(largest, std::fabs(value));
  const bool still = largest < 0x1p-100f;
  const float inverse = still ? 0 : limit / largest, step = still ? 0 : largest / limit;
  std::vector<float> y(layer.outputs);
  for (std::size_t o = 0; o < layer.outputs; ++o) {
    std::int64_t high = 0, low = 0;
    for (std::size_t i = 0; i < layer.inputs; ++i) {
      const auto q = static_cast<std::int64_t>(std::nearbyint(x[i] * inverse));
      const int weight = layer.weights[o * layer.inputs + i];
      high += q * (layer.wide ? high_digit(weight) : weight);
      low += q * (layer.wide ? low_digit(weight) : 0);
    }
    const float sum = layer.wide ? 256 * static_cast<float>(high) + static_cast<float>(low) : static_cast<float>(high);
    y[o] = activated(layer.activation, (layer.scales[o] * step) * sum + layer.bias[o]);
    if (layer.skip) y[o] += x[o];
  }
  return y;
}

}  // namespace

std::string add_layers(OnnxGraph& graph, const PackedRegion& region, const std::string& x, std::uint64_t& parameters) {
  const std::string label = "region/" + region.name;
  std::string y = x;
  std::vector<float> rest(region.features.size(), 0);
  for (std::size_t l = 0; l < region.layers.size(); ++l) {
    y = add_layer(graph, label + "/" + std::to_string(l), region.layers[l], y, parameters);
    rest = evaluate_layer(region.layers[l], rest);
  }
  return graph.node("Sub", label,
                    {y, graph.floats(label + "/rest", rest, {1, static_cast<std::int64_t>(rest.size())})});
}

}  // namespace fb::bake
