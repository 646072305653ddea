// The matrices of the runtime: dense layers and the basis are multiplied with vectors through them.
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

namespace fb::runtime {

// A matrix of digits, -128 to 127, cut into panels of rows. In a panel rows lie side by side, so that a loop over rows
// is a loop over lanes.
class PanelMatrix {
 public:
  enum class Form {
    columns,  // column after column: those whose input is 0 are not read
    quads,    // quad_columns columns interleaved: every column is multiplied with an input
  };

  // A whole number is 256 * high + low; one of 8 bits is its own low digit.
  enum class Digit { low, high };

  // Digits are 0 until they are set, all of them by whole columns or by whole rows; then find_limit() is called.
  PanelMatrix(Form form, std::uint32_t rows, std::size_t columns, std::pmr::memory_resource& memory)
      : form_(form), rows_(rows), columns_(columns), lines_((columns + width() - 1) / width()), blocks_(&memory) {
    const std::uint32_t last = rows > 0 ? (rows - 1) / panel_rows() * panel_rows() : 0;
    const std::size_t stored = last + stored_rows(last);
    const std::size_t bytes = checked_multiply(checked_multiply(stored, lines_, "a matrix"), width(), "a matrix");
    Block zeros;
    std::fill(std::begin(zeros.digit), std::end(zeros.digit), std::uint8_t(128));
    blocks_.resize((bytes + sizeof(Block) - 1) / sizeof(Block), zeros);
  }

  // To the digits of these numbers, one a row.
  void set_column(std::size_t column, const std::int16_t* numbers, Digit digit) {
    for (std::uint32_t first = 0; first < rows_; first += panel_rows()) {
      const std::size_t step = width();
      std::uint8_t* const to = at(first, column);
      for (std::size_t r = 0; r < rows_at(first); ++r) to[r * step] = stored(numbers[first + r], digit);
    }
  }
  // One a column.
  void set_row(std::uint32_t row, const std::int16_t* numbers, Digit digit) {
    const std::size_t step = stored_rows(row / panel_rows() * panel_rows()) * width();
    for (std::size_t within = 0; within < std::min(width(), columns_); ++within) {
      std::uint8_t* to = at(row, within);
      for (std::size_t c = within; c < columns_; c += width(), to += step) *to = stored(numbers[c], digit);
    }
  }

  void find_limit() {
    std::uint32_t heaviest = 0;
    for (std::uint32_t first = 0; first < rows_; first += panel_rows()) {
      constexpr std::size_t longest = std::max(column_rows, quad_rows * quad_columns);  // line
      std::uint32_t weights[longest] = {};  // at most max_row_inputs times 128
      const std::size_t length = stored_rows(first) * width();
      constexpr std::size_t few = 256;  // whose sum fits 16 bits
      for (std::size_t begin = 0; begin < lines_; begin += few) {
        std::uint16_t some[longest] = {};
        for (std::size_t l = begin; l < std::min(lines_, begin + few); ++l) {
          const std::uint8_t* const line = panel(first) + l * length;
          for (std::size_t i = 0; i < length; ++i) some[i] += static_cast<std::uint16_t>(std::abs(line[i] - 128));
        }
        for (std::size_t i = 0; i < length; ++i) weights[i] += some[i];
      }
      for (std::size_t r = 0; r < rows_at(first); ++r) {
        std::uint32_t weight = 0;
        for (std::size_t i = 0; i < width(); ++i) weight += weights[r * width() + i];
        heaviest = std::max(heaviest, weight);
      }
    }
    if (heaviest > 0) limit_ = static_cast<std::int32_t>(std::min<std::uint32_t>(limit_, INT32_MAX / heaviest));
  }

  std::uint32_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }

  // The largest input with which no sum of a row, however inputs are signed, leaves 32 bits; at least 1 if columns()
  // is at most max_row_inputs.
  std::int32_t limit() const { return limit_; }

  std::uint32_t panel_rows() const { return form_ == Form::quads ? quad_rows : column_rows; }
  // How many rows the panel has that begins at row `first`, a multiple of panel_rows().
  std::uint32_t rows_at(std::uint32_t first) const { return std::min(panel_rows(), rows_ - first); }

  // The sums of that panel: most_rows numbers a pose, of which those beyond its rows are anything.
  void sum(const PoseKernels& kernels, std::uint32_t first, const PanelInputs& inputs, std::int32_t* sums) const {
    (form_ == Form::quads ? kernels.quad_sums : kernels.column_sums)(panel(first), whole_vectors(rows_at(first)),
                                                                     inputs, sums);
  }

  // Asks the processor for a column's digits, of a matrix in the form of columns.
  void fetch(std::size_t column) const {
    for (std::uint32_t first = 0; first < rows_; first += column_rows)
      for (std::uint32_t r = 0; r < rows_at(first); r += sizeof(Block))
        __builtin_prefetch(panel(first) + column_rows * column + r);
  }

  int digit(std::uint32_t row, std::size_t column) const {
    return *const_cast<PanelMatrix*>(this)->at(row, column) - 128;
  }

 private:
  struct alignas(64) Block {
    std::uint8_t digit[64];
  };
  static std::uint8_t stored(std::int16_t number, Digit digit) {
    return static_cast<std::uint8_t>((digit == Digit::low ? number : (number + 128) >> 8) + 128);
  }
  static std::uint32_t whole_vectors(std::uint32_t rows) { return (rows + 15) / 16 * 16; }
  // Of a line, which is a column or a quad.
  std::size_t width() const { return form_ == Form::quads ? quad_columns : 1; }
  std::size_t stored_rows(std::uint32_t first) const {
    return form_ == Form::quads ? whole_vectors(rows_at(first)) : column_rows;
  }
  // All panels before this one are full.
  const std::uint8_t* panel(std::uint32_t first) const {
    return reinterpret_cast<const std::uint8_t*>(blocks_.data()) + first * lines_ * width();
  }
  std::uint8_t* at(std::uint32_t row, std::size_t column) {
    const std::uint32_t first = row / panel_rows() * panel_rows();
    const std::size_t place = column / width() * stored_rows(first) + (row - first);
    return const_cast<std::uint8_t*>(panel(first)) + place * width() +
           (form_ == Form::quads ? place_in_quad(column) : 0);
  }

  Form form_;
  std::uint32_t rows_;
  std::size_t columns_, lines_;
  std::int32_t limit_ = largest_wide;
  std::pmr::vector<Block> blocks_;
};

}  // namespace fb::runtime
