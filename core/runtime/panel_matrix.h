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
  // A whole number is 256 * high + low; one of 8 bits is its own low digit.
  enum class Digit { low, high };

  // Digits are -128 until they are set, all of them by whole columns or by whole rows; then find_limit() is called.
  PanelMatrix(std::uint32_t rows, std::size_t columns, std::pmr::memory_resource& memory)
      : rows_(rows), columns_(columns), lines_(&memory) {
    std::size_t stored = 0;
    for (std::uint32_t first = 0; first < rows; first += panel_rows) stored += stored_rows(first);
    lines_.resize((checked_multiply(stored, columns, "a matrix") + sizeof(Line) - 1) / sizeof(Line));
  }

  // To the digits of these numbers, one a row.
  void set_column(std::size_t column, const std::int16_t* numbers, Digit digit) {
    for (std::uint32_t first = 0; first < rows_; first += panel_rows, numbers += panel_rows) {
      std::uint8_t* const to = const_cast<std::uint8_t*>(digits(first, column));
      set(to, 1, numbers, rows_at(first), digit);
    }
  }
  // One a column.
  void set_row(std::uint32_t row, const std::int16_t* numbers, Digit digit) {
    const std::uint32_t first = row / panel_rows * panel_rows;
    set(const_cast<std::uint8_t*>(digits(first, 0)) + (row - first), stored_rows(first), numbers, columns_, digit);
  }

  void find_limit() {
    std::uint32_t heaviest = 0;
    for (std::uint32_t first = 0; first < rows_; first += panel_rows) {
      std::uint32_t weights[panel_rows] = {};  // at most most_summands times 128
      const std::size_t stored = stored_rows(first);
      constexpr std::size_t few = 256;  // whose sum fits 16 bits
      for (std::size_t begin = 0; begin < columns_; begin += few) {
        std::uint16_t some[panel_rows] = {};
        for (std::size_t c = begin; c < std::min(columns_, begin + few); ++c) {
          const std::uint8_t* const column = digits(first, c);
          for (std::size_t r = 0; r < stored; ++r) some[r] += static_cast<std::uint16_t>(std::abs(column[r] - 128));
        }
        for (std::size_t r = 0; r < stored; ++r) weights[r] += some[r];
      }
      heaviest = std::max(heaviest, *std::max_element(weights, weights + rows_at(first)));
    }
    if (heaviest > 0) limit_ = static_cast<std::int32_t>(std::min<std::uint32_t>(limit_, INT32_MAX / heaviest));
  }

  std::uint32_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }

  // The largest input with which no sum of a row, however inputs are signed, leaves 32 bits; at least 1 if columns()
  // is at most most_summands.
  std::int32_t limit() const { return limit_; }

  // How many rows the panel has that begins at row `first`, a multiple of panel_rows.
  std::uint32_t rows_at(std::uint32_t first) const { return std::min(std::uint32_t(panel_rows), rows_ - first); }

  // Where that panel's digits begin; null beyond the last.
  const std::uint8_t* panel(std::uint32_t first) const { return first < rows_ ? digits(first, 0) : nullptr; }

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
  // Every `step` bytes.
  static void set(std::uint8_t* to, std::size_t step, const std::int16_t* numbers, std::size_t count, Digit digit) {
    if (digit == Digit::low)
      for (std::size_t i = 0; i < count; ++i) to[i * step] = static_cast<std::uint8_t>(numbers[i] + 128);
    else
      for (std::size_t i = 0; i < count; ++i) to[i * step] = static_cast<std::uint8_t>(((numbers[i] + 128) >> 8) + 128);
  }
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
