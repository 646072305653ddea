#include "runtime/row_block_matrix.h"

#include <algorithm>

namespace fb::runtime {
namespace {

PanelMatrix digits_of(const PackedRowBlock& group, std::pmr::memory_resource& memory) {
  const auto wide = std::count_if(group.columns.begin(), group.columns.end(), [](const auto& c) { return c.wide; });
  PanelMatrix digits(PanelMatrix::Form::columns, group.row_count, group.columns.size() + static_cast<std::size_t>(wide),
                     memory);
  std::size_t high = group.columns.size();
  for (std::size_t c = 0; c < group.columns.size(); ++c) {
    const std::int16_t* values = group.values.data() + c * group.row_count;
    digits.set_column(c, values, PanelMatrix::Digit::low);
    if (group.columns[c].wide) digits.set_column(high++, values, PanelMatrix::Digit::high);
  }
  digits.find_limit();
  return digits;
}

}  // namespace

RowBlockMatrix::RowBlockMatrix(const PackedRowBlock& group, std::pmr::memory_resource& memory)
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

std::pair<RowBlockMatrix::Span, RowBlockMatrix::Span> RowBlockMatrix::summands_of(std::uint32_t first_column,
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

void RowBlockMatrix::run(const PoseKernels& kernels, const Quantized& summands, const float* rest,
                         float* const* rows) const {
  for (std::uint32_t first = 0; first < row_count(); first += digits_.panel_rows()) {
    std::int32_t sums[block_poses * most_rows];
    digits_.sum(kernels, first, summands.panel_inputs(), sums);
    for (std::size_t pose = 0; pose < summands.poses; ++pose)
      if (summands.steps[pose] != 0)
        kernels.move_rows(sums + most_rows * pose, summands.steps[pose], rest + first, rows[pose] + first,
                          digits_.rows_at(first));
  }
}

void RowBlockMatrix::displacements(std::size_t place, float* moved) const {
  const auto wide = std::lower_bound(columns_.begin() + column_count_, columns_.end(), columns_[place]);
  const std::size_t high = wide - columns_.begin();
  const bool has_high = wide != columns_.end() && *wide == columns_[place];
  for (std::uint32_t r = 0; r < row_count(); ++r) {
    const int value = digits_.digit(r, place) + (has_high ? 256 * digits_.digit(r, high) : 0);
    moved[r] = scales_[place] * static_cast<float>(value);
  }
}

}  // namespace fb::runtime
