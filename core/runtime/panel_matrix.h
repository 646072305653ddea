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
#include "runtime/kernels/panel_sums.h"

namespace fb {

// A matrix of digits, -128 to 127, in panels of at most 64 rows. A panel's digits lie column after column, rows side by
// side, so that a loop over rows is a loop over lanes and a column whose input is 0 is never read.
class PanelMatrix {
 public:
  static constexpr std::uint32_t panel_rows = 64;

  // digit(row, column) gives the numbers.
  template <class Digit>
  PanelMatrix(std::uint32_t rows, std::size_t columns, Digit&& digit, std::pmr::memory_resource& memory)
      : rows_(rows), columns_(columns), lines_(&memory) {
    std::size_t lines = 0;
    for (std::uint32_t first = 0; first < rows; first += panel_rows) lines += lines_of(first);
    lines_.resize(checked_multiply(lines, columns, "a matrix"));
    std::int64_t heaviest = 0;
    Line* line = lines_.data();
    for (std::uint32_t first = 0; first < rows; first += panel_rows) {
      std::int64_t weights[panel_rows] = {};
      for (std::size_t column = 0; column < columns; ++column, line += lines_of(first))
        for (std::uint32_t r = 0; r < rows_at(first); ++r) {
          const int d = digit(first + r, column);
          line[r / 16].digit[r % 16] = static_cast<std::int8_t>(d);
          weights[r] += std::abs(d);
        }
      heaviest = std::max(heaviest, *std::max_element(weights, weights + panel_rows));
    }
    if (heaviest > 0) limit_ = static_cast<std::int32_t>(std::min<std::int64_t>(limit_, INT32_MAX / heaviest));
  }

  std::uint32_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }

  // The largest input with which no sum of a row, however inputs are signed, leaves 32 bits; at least 1 if columns()
  // is at most most_summands.
  std::int32_t limit() const { return limit_; }

  // Calls finish(row, count, sums) for each panel in the order of rows.
  template <class Finish>
  void multiply(std::span<const ActiveColumn> active, Finish&& finish) const {
    for (std::uint32_t first = 0; first < rows_; first += panel_rows) {
      alignas(64) std::int32_t sums[panel_rows];
      sum(first, active, sums);
      finish(first, rows_at(first), static_cast<const std::int32_t*>(sums));
    }
  }

  // The sums of the panel that begins at row `first`, a multiple of panel_rows.
  void sum(std::uint32_t first, std::span<const ActiveColumn> active, std::int32_t* sums) const {
    // All panels before this one are full.
    const auto* digits = reinterpret_cast<const std::int8_t*>(lines_.data() + std::size_t(first / 16) * columns_);
    panel_sums(digits, std::size_t(16) * lines_of(first), active, sums);
  }

 private:
  struct alignas(16) Line {
    std::int8_t digit[16];
  };
  std::uint32_t rows_at(std::uint32_t first) const { return std::min(panel_rows, rows_ - first); }
  std::uint32_t lines_of(std::uint32_t first) const { return (rows_at(first) + 15) / 16; }

  std::uint32_t rows_;
  std::size_t columns_;
  std::int32_t limit_ = largest_wide;
  std::pmr::vector<Line> lines_;
};

}  // namespace fb
