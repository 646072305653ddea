#include "bake/export/onnx_basis.h"

#include <algorithm>
#include <cstdlib>

#include "bake/export/onnx_rounding.h"

namespace fb::bake {
namespace {

// A row block as a matrix of digits: one input for a column of 8-bit values, two for one of 16-bit values.
struct DigitMatrix {
  std::vector<std::uint32_t> columns;  // of each input
  std::vector<float> scales, digits;   // digits: inputs x rows
  float limit = 0;
};

DigitMatrix digits_of(const PackedRowBlock& block) {
  DigitMatrix matrix;
  std::vector<std::uint64_t> sums(block.row_count, 0);
  const auto add = [&](const PackedColumn& column, float scale, std::span<const std::int16_t> values, auto&& digit) {
    matrix.columns.push_back(column.column);
    matrix.scales.push_back(scale);
    for (std::size_t row = 0; row < values.size(); ++row) {
      const int number = digit(values[row]);
      sums[row] += static_cast<std::uint64_t>(std::abs(number));
      matrix.digits.push_back(static_cast<float>(number));
    }
  };
  for (std::size_t c = 0; c < block.columns.size(); ++c) {
    const PackedColumn& column = block.columns[c];
    const std::span values = std::span(block.values).subspan(c * block.row_count, block.row_count);
    if (!column.wide) {
      add(column, column.scale, values, [](int value) { return value; });
      continue;
    }
    const int bits = low_digit_bits(values.data(), values.size());
    const float base = static_cast<float>(1 << bits);
    add(column, column.scale * base, values, [&](int value) { return high_digit(value, bits); });
    add(column, column.scale, values, [&](int value) { return low_digit(value, bits); });
  }
  matrix.limit = rounding_limit(sums.empty() ? 0 : *std::ranges::max_element(sums));
  return matrix;
}

}  // namespace

std::string add_basis(OnnxGraph& graph, const PackedModel& model, const std::string& coefficients,
                      std::uint64_t& parameters) {
  std::vector<std::string> parts;
  for (const PackedRowBlock& block : model.row_blocks) {
    DigitMatrix matrix = digits_of(block);
    if (matrix.columns.empty()) {  // rows that nothing moves
      matrix.columns = {0};
      matrix.scales = {0};
      matrix.digits.assign(block.row_count, 0);
    }
    parameters += matrix.digits.size() + matrix.scales.size();
    const auto inputs = static_cast<std::int64_t>(matrix.columns.size());
    std::string x =
        graph.node("Gather", "basis", {coefficients, graph.indices("basis/columns", matrix.columns)}, {{"axis", {1}}});
    x = graph.node("Mul", "basis", {x, graph.floats("basis/scales", matrix.scales, {1, inputs})});
    const RoundedInputs rounded = round_inputs(graph, "basis", x, matrix.limit);
    parts.push_back(graph.node("Mul", "basis",
                               {rounded.step, digit_sums(graph, "basis", rounded, matrix.digits, block.row_count)}));
  }
  return graph.node("Concat", "rows", parts, {{"axis", {1}}});
}

std::string add_corrections(OnnxGraph& graph, const PackedModel& model, const std::string& points,
                            const std::string& weights, std::uint64_t& parameters) {
  const std::string label = "exact/corrections";
  std::string corrected = points;
  std::vector<float> corrections(model.rest.points.size());
  for (std::uint32_t e = 0; e < model.exact.size(); ++e) {
    const ExactPose& pose = model.exact[e];
    for (std::uint32_t row = 0; row < corrections.size(); ++row)
      corrections[model.coordinate(row)] = pose.step * static_cast<float>(pose.values[row]);
    parameters += corrections.size();
    const std::uint32_t column[] = {e};
    const std::string weight = graph.node("Gather", label, {weights, graph.indices(label, column)}, {{"axis", {1}}});
    const std::string correction = graph.floats(label, corrections, {1, static_cast<std::int64_t>(corrections.size())});
    corrected = graph.node("Add", label, {corrected, graph.node("Mul", label, {weight, correction})});
  }
  return corrected;
}

}  // namespace fb::bake
