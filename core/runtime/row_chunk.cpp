#include "runtime/row_chunk.h"

#include <algorithm>

namespace fb {
namespace {

PanelMatrix digits_of(const PackedRowGroup& group, std::pmr::memory_resource& memory) {
  const auto count = static_cast<std::uint32_t>(group.columns.size());
  std::vector<std::uint32_t> wide;
  for (std::uint32_t c = 0; c < count; ++c)
    if (group.columns[c].wide) wide.push_back(c);
  const auto write_column = [&](std::size_t summand, std::int16_t* digits) {
    const std::size_t c = summand < count ? summand : wide[summand - count];
    const std::int16_t* values = group.values.data() + c * group.row_count;
    if (!group.columns[c].wide)
      std::copy_n(values, group.row_count, digits);
    else
      for (std::uint32_t r = 0; r < group.row_count; ++r)
        digits[r] = static_cast<std::int16_t>(summand < count ? low_digit(values[r]) : high_digit(values[r]));
  };
  return PanelMatrix(group.row_count, count + wide.size(), write_column, memory);
}

}  // namespace

RowChunk::RowChunk(const PackedRowGroup& group, std::pmr::memory_resource& memory)
    : first_row_(group.first_row),
      column_count_(group.columns.size()),
      columns_(&memory),
      scales_(&memory),
      digits_(digits_of(group, memory)) {
  columns_.reserve(digits_.columns());
  scales_.reserve(digits_.columns());
  for (const bool high : {false, true})
    for (const PackedColumn& column : group.columns)
      if (column.wide || !high) {
        columns_.push_back(column.column);
        scales_.push_back(high ? 256 * column.scale : column.scale);
      }
}

std::pair<RowChunk::Span, RowChunk::Span> RowChunk::summands_of(std::uint32_t first_column,
                                                                std::uint32_t last_column) const {
  const auto part = [&](std::size_t begin, std::size_t end) {
    const auto at = [&](std::uint32_t column) {
      return static_cast<std::uint32_t>(std::lower_bound(columns_.begin() + begin, columns_.begin() + end, column) -
                                        columns_.begin());
    };
    return Span{at(first_column), at(last_column)};
  };
  return {part(0, column_count_), part(column_count_, columns_.size())};
}

void RowChunk::fetch(const std::uint32_t* places, std::size_t count) const {
  for (std::uint32_t first = 0; first < row_count(); first += panel_rows)
    for (std::size_t i = 0; i < count; ++i) digits_.fetch(first, places[i]);
}

void RowChunk::run(const PoseKernels& kernels, const PoseNumbers& summands, std::size_t poses, Quantized& quantized,
                   const float* rest, float* const* rows, bool* moved) const {
  if (!quantized.quantize(kernels, summands, static_cast<float>(digits_.limit()), poses)) return;
  for (std::uint32_t first = 0; first < row_count(); first += panel_rows) {
    std::int32_t sums[block_poses * panel_rows];
    digits_.sum(kernels, first, quantized.columns(), sums);
    for (std::size_t pose = 0; pose < poses; ++pose)
      if (quantized.step(pose) != 0)
        kernels.move_rows(sums + panel_rows * pose, quantized.step(pose), rest + first, rows[pose] + first,
                          digits_.rows_at(first));
  }
  for (std::size_t pose = 0; pose < poses; ++pose) moved[pose] = quantized.step(pose) != 0;
}

void RowChunk::displacements(std::size_t place, float* moved) const {
  const auto wide = std::lower_bound(columns_.begin() + column_count_, columns_.end(), columns_[place]);
  const std::size_t high = wide - columns_.begin();
  const bool has_high = wide != columns_.end() && *wide == columns_[place];
  for (std::uint32_t r = 0; r < row_count(); ++r) {
    const int value = digits_.digit(r, place) + (has_high ? 256 * digits_.digit(r, high) : 0);
    moved[r] = scales_[place] * static_cast<float>(value);
  }
}

}  // namespace fb
