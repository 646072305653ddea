#include "bake/export/onnx_rounding.h"

#include <algorithm>

namespace fb::bake {
namespace {

constexpr float smallest = 0x1p-100f;  // inputs that are all below it count as 0

}  // namespace

float rounding_limit(std::uint64_t largest_sum) {
  const std::uint64_t most = largest_wide;
  return static_cast<float>(largest_sum > 0 ? std::min<std::uint64_t>(most, INT32_MAX / largest_sum) : most);
}

RoundedInputs round_inputs(OnnxGraph& graph, const std::string& label, const std::string& inputs, float limit) {
  const std::string name = label + "/rounded", most = graph.number(name, limit);
  const std::string sizes = graph.node("Abs", name, {inputs});
  std::string largest = graph.node("ReduceMax", name, {sizes}, {{"axes", {1}, true}});
  largest = graph.node("Max", name, {largest, graph.number(name, smallest)});
  const std::string inverse = graph.node("Div", name, {most, largest});
  const std::string whole = graph.node("Round", name, {graph.node("Mul", name, {inputs, inverse})});
  const std::string shifted = graph.node("Add", name, {whole, graph.number(name, 128)});
  const std::string high = graph.node("Floor", name, {graph.node("Mul", name, {shifted, graph.number(name, 0x1p-8f)})});
  const std::string above = graph.node("Mul", name, {high, graph.number(name, 256)});
  return {high, graph.node("Sub", name, {whole, above}), graph.node("Div", name, {largest, most})};
}

std::string digit_sums(OnnxGraph& graph, const std::string& label, const RoundedInputs& inputs,
                       std::span<const float> digits, std::size_t outputs) {
  const std::string matrix =
      graph.floats(label + "/digits", digits,
                   {static_cast<std::int64_t>(digits.size() / outputs), static_cast<std::int64_t>(outputs)});
  const std::string high = graph.node("MatMul", label, {inputs.high, matrix}),
                    low = graph.node("MatMul", label, {inputs.low, matrix});
  return graph.node("Add", label, {graph.node("Mul", label, {high, graph.number(label, 256)}), low});
}

}  // namespace fb::bake
