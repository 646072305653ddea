// The one matrix form of the runtime: dense layers and the basis are both multiplied with a vector through it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory_resource>
#include <vector>

#include "base/checked.h"
#include "model/packed_model.h"
#include "runtime/kernels/panel_kernels.h"

namespace fb {

// A matrix of digits, -128 to 127, in panels of at most panel_rows rows. A panel's digits lie column after column, rows
// side by side, so that a loop over rows is a loop over lanes and a column whose input is 0 is never read.
class PanelMatrix {
 public:
  // write_column(column, digits) writes the digits of a column, one a row.
  template <class WriteColumn>
  PanelMatrix(std::uint32_t rows, std::size_t columns, WriteColumn&& write_column, std::pmr::memory_resource& memory)
      : rows_(rows), columns_(columns), lines_(&memory) {
    std::size_t stored = 0;
    for (std::uint32_t first = 0; first < rows; first += panel_rows) stored += stored_rows(first);
    lines_.resize((checked_multiply(stored, columns, "a matrix") + sizeof(Line) - 1) / sizeof(Line));
    std::vector<std::int16_t> column(rows);
    std::vector<std::uint32_t> weights(rows);  // at most most_summands times 128
    for (std::size_t c = 0; c < columns; ++c) {
      write_column(c, column.data());
      for (std::uint32_t r = 0; r < rows; ++r) weights[r] += static_cast<std::uint32_t>(std::abs(int(column[r])));
      for (std::uint32_t first = 0; first < rows; first += panel_rows) {
        std::uint8_t* const to = const_cast<std::uint8_t*>(digits(first, c));
        const std::uint32_t count = rows_at(first);
        for (std::uint32_t r = 0; r < count; ++r) to[r] = static_cast<std::uint8_t>(column[first + r] + 128);
      }
    }
    const std::uint32_t heaviest = rows == 0 ? 0 : *std::max_element(weights.begin(), weights.end());
    if (heaviest > 0) limit_ = static_cast<std::int32_t>(std::min<std::uint32_t>(limit_, INT32_MAX / heaviest));
  }

  std::uint32_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }

  // The largest input with which no sum of a row, however inputs are signed, leaves 32 bits; at least 1 if columns()
  // is at most most_summands.
  std::int32_t limit() const { return limit_; }

  // How many rows the panel has that begins at row `first`, a multiple of panel_rows.
  std::uint32_t rows_at(std::uint32_t first) const { return std::min(std::uint32_t(panel_rows), rows_ - first); }

  // The sums of that panel: panel_rows numbers a pose.
  void sum(const PoseKernels& kernels, std::uint32_t first, const ActiveColumns& active, std::int32_t* sums) const {
    kernels.panel_sums(digits(first, 0), stored_rows(first), active, sums);
  }

  void fetch(std::uint32_t first, std::size_t column) const { __builtin_prefetch(digits(first, column)); }

  int digit(std::uint32_t row, std::size_t column) const {
    const auto first = static_cast<std::uint32_t>(row / panel_rows * panel_rows);
    return digits(first, column)[row - first] - 128;
  }

 private:
  struct alignas(64) Line {
    std::uint8_t digit[64];
  };
  std::size_t stored_rows(std::uint32_t first) const { return (rows_at(first) + 15) / 16 * 16; }
  // Of a panel's column. All panels before this one are full.
  const std::uint8_t* digits(std::uint32_t first, std::size_t column) const {
    return reinterpret_cast<const std::uint8_t*>(lines_.data()) + first * columns_ + stored_rows(first) * column;
  }

  std::uint32_t rows_;
  std::size_t columns_;
  std::int32_t limit_ = largest_wide;
  std::pmr::vector<Line> lines_;
};

}  // namespace fb
