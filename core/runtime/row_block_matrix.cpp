#include "runtime/row_block_matrix.h"

#include <algorithm>
#include <span>

namespace fb::runtime {
namespace {

// See low_digit_bits, of the wide columns.
std::pmr::vector<std::uint8_t> bits_of(const PackedRowBlock& block, std::pmr::memory_resource& memory) {
  std::pmr::vector<std::uint8_t> bits(&memory);
  bits.reserve(static_cast<std::size_t>(std::count_if(block.columns.begin(), block.columns.end(),
                                                      [](const PackedColumn& column) { return column.wide; })));
  for (std::size_t c = 0; c < block.columns.size(); ++c)
    if (block.columns[c].wide)
      bits.push_back(
          static_cast<std::uint8_t>(low_digit_bits(block.values.data() + c * block.row_count, block.row_count)));
  return bits;
}

PanelMatrix digits_of(const PoseKernels& kernels, const PackedRowBlock& block, std::span<const std::uint8_t> wide_bits,
                      std::pmr::memory_resource& memory) {
  PanelMatrix digits(kernels, PanelMatrix::Form::columns, block.row_count, block.columns.size() + wide_bits.size(),
                     memory);
  std::size_t wide = 0;
  for (std::size_t c = 0; c < block.columns.size(); ++c) {
    const std::int16_t* values = block.values.data() + c * block.row_count;
    if (!block.columns[c].wide) {
      digits.set_column(c, values, {});
      continue;
    }
    const int bits = wide_bits[wide];
    digits.set_column(c, values, {.high = false, .low_bits = bits});
    digits.set_column(block.columns.size() + wide++, values, {.high = true, .low_bits = bits});
  }
  digits.find_limit();
  return digits;
}

}  // namespace

RowBlockMatrix::RowBlockMatrix(const PoseKernels& kernels, const PackedRowBlock& block,
                               std::pmr::memory_resource& memory)
    : first_row_(block.first_row),
      column_count_(block.columns.size()),
      columns_(&memory),
      scales_(&memory),
      wide_bits_(bits_of(block, memory)),
      digits_(digits_of(kernels, block, wide_bits_, memory)) {
  columns_.reserve(digits_.columns());
  scales_.reserve(digits_.columns());
  for (const PackedColumn& column : block.columns) {
    columns_.push_back(column.column);
    scales_.push_back(column.scale);
  }
  for (const PackedColumn& column : block.columns)
    if (column.wide) {
      scales_.push_back(column.scale * static_cast<float>(1 << wide_bits_[columns_.size() - column_count_]));
      columns_.push_back(column.column);
    }
}

std::pair<RowBlockMatrix::InputRange, RowBlockMatrix::InputRange> RowBlockMatrix::inputs_of(
    std::uint32_t first_column, std::uint32_t last_column) const {
  const auto range = [&](std::size_t begin, std::size_t end) {
    const auto at = [&](std::uint32_t column) {
      return static_cast<std::uint32_t>(std::lower_bound(columns_.begin() + begin, columns_.begin() + end, column) -
                                        columns_.begin());
    };
    return InputRange{at(first_column), at(last_column)};
  };
  return {range(0, column_count_), range(column_count_, columns_.size())};
}

void RowBlockMatrix::run(const QuantisedInputs& inputs, const float* rest, float* const* rows) const {
  for (std::uint32_t first = 0; first < row_count(); first += digits_.panel_rows()) {
    float* to[poses_per_block];
    for (std::size_t pose = 0; pose < inputs.poses; ++pose) to[pose] = rows[pose] + first;
    digits_.multiply(first, inputs.panel_inputs(), {nullptr, rest + first, inputs.steps, to});
  }
}

RowBlockMatrix::Digits RowBlockMatrix::find_digits(std::size_t input) const {
  const auto wide = std::lower_bound(columns_.begin() + column_count_, columns_.end(), columns_[input]);
  if (wide == columns_.end() || *wide != columns_[input]) return {input, input, 0};
  const std::size_t high = wide - columns_.begin();
  return {input, high, 1 << wide_bits_[high - column_count_]};
}

float RowBlockMatrix::value(const Digits& digits, std::uint32_t row) const {
  const int high = digits.base > 0 ? digits.base * digits_.digit(row, digits.high) : 0;
  return scales_[digits.low] * static_cast<float>(digits_.digit(row, digits.low) + high);
}

float RowBlockMatrix::displacement(std::size_t input, std::uint32_t row) const {
  return value(find_digits(input), row);
}

void RowBlockMatrix::displacements(std::size_t input, float* values) const {
  const Digits digits = find_digits(input);
  for (std::uint32_t r = 0; r < row_count(); ++r) values[r] = value(digits, r);
}

}  // namespace fb::runtime
