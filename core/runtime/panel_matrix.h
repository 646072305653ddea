// The matrices of the runtime: the layers of networks and the row blocks of the basis.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory_resource>
#include <vector>

#include "base/checked.h"
#include "model/packed_model.h"
#include "runtime/kernels/pose_kernels.h"

namespace fb::runtime {

// WebAssembly has no prefetches, and would compute the addresses for nothing.
#if defined(__wasm__)
inline constexpr bool has_prefetch = false;
#else
inline constexpr bool has_prefetch = true;
#endif

// A matrix of signed 8-bit digits, cut into panels of rows, laid out for some kernels. The rows of a panel are
// contiguous, so that kernels vectorise over rows.
class PanelMatrix {
 public:
  enum class Form {
    columns,  // column-major, for sparse inputs: columns without an input are not read
    quads,    // quad_columns columns interleaved, for dense inputs
  };

  // Which digit of a value, see low_digit; a narrow value is its own low digit of 8 bits.
  struct Digit {
    bool high = false;
    int low_bits = 8;
  };

  // All digits are 0. Set them by columns or by rows, then call find_limit().
  PanelMatrix(const PoseKernels& kernels, Form form, std::uint32_t rows, std::size_t columns,
              std::pmr::memory_resource& memory)
      : kernels_(&kernels),
        form_(form),
        rows_(rows),
        columns_(columns),
        lines_((columns + width() - 1) / width()),
        column_length_(static_cast<std::uint32_t>(stored_rows(0))),
        blocks_(&memory) {
    const std::uint32_t last = rows > 0 ? (rows - 1) / panel_rows() * panel_rows() : 0;
    const std::size_t all_rows = last + stored_rows(last);
    const std::size_t bytes = checked_multiply(checked_multiply(all_rows, lines_, "a matrix"), width(), "a matrix");
    if (form == Form::columns)
      checked_u32(checked_multiply(columns, column_length_, "a matrix"), "a panel of a matrix");
    Block zeros;
    for (std::size_t i = 0; i < sizeof(Block); ++i) zeros.digit[i] = stored(0, &zeros.digit[i]);
    blocks_.resize((bytes + sizeof(Block) - 1) / sizeof(Block), zeros);
    for (std::size_t r = 0; r < column_group; ++r) added_to_row_[r] = stored(0, &zeros.digit[kernels.column_rows[r]]);
  }

  // Sets a column of a matrix of Form::columns to a digit of `values`, one a row.
  void set_column(std::size_t column, const std::int16_t* values, Digit digit) {
    const std::uint8_t* const places = kernels_->column_rows;
    for (std::uint32_t first = 0; first < rows_; first += column_panel_rows) {
      std::uint8_t* const line = const_cast<std::uint8_t*>(panel(first)) + column * stored_rows(first);
      for (std::uint32_t group = 0; group < rows_at(first); group += column_group) {
        const std::uint32_t count = std::min<std::uint32_t>(column_group, rows_at(first) - group);
        std::uint8_t stored_digits[column_group];  // by row: vectorised apart from their placing
        find_digits(values + first + group, count, digit, stored_digits);
        if (count == column_group)
          for (std::size_t r = 0; r < column_group; ++r) line[group + places[r]] = stored_digits[r];
        else
          for (std::size_t r = 0; r < count; ++r) line[group + places[r]] = stored_digits[r];
      }
    }
  }
  // Sets a row to a digit of `values`, one a column.
  void set_row(std::uint32_t row, const std::int16_t* values, Digit digit) {
    const std::size_t step = stored_rows(row / panel_rows() * panel_rows()) * width();
    for (std::size_t within = 0; within < std::min(width(), columns_); ++within) {
      std::uint8_t* to = at(row, within);
      for (std::size_t c = within; c < columns_; c += width(), to += step) *to = stored(number(values[c], digit), to);
    }
  }

  // Computes limit() from the largest sum of |digit| over a row.
  void find_limit() {
    if (columns_ == 0) return;  // there are no digits
    std::uint32_t largest_sum = 0;
    for (std::uint32_t first = 0; first < rows_; first += panel_rows()) {
      constexpr std::size_t max_length = std::max(column_panel_rows, quad_panel_rows * quad_columns);
      std::uint32_t sums[max_length] = {};  // at most 128 * max_row_inputs
      const std::size_t length = stored_rows(first) * width();
      std::uint8_t added[max_length];
      for (std::size_t i = 0; i < length; ++i) added[i] = static_cast<std::uint8_t>(added_at(panel(first) + i));
      constexpr std::size_t lines_at_once = 256;  // their sum fits 16 bits
      for (std::size_t begin = 0; begin < lines_; begin += lines_at_once) {
        std::uint16_t partial[max_length] = {};
        for (std::size_t l = begin; l < std::min(lines_, begin + lines_at_once); ++l) {
          const std::uint8_t* const line = panel(first) + l * length;
          for (std::size_t i = 0; i < length; ++i)
            partial[i] += static_cast<std::uint16_t>(std::abs(static_cast<std::int8_t>(line[i] - added[i])));
        }
        for (std::size_t i = 0; i < length; ++i) sums[i] += partial[i];
      }
      for (std::size_t r = 0; r < stored_rows(first); ++r) {
        std::uint32_t sum = 0;
        for (std::size_t i = 0; i < width(); ++i) sum += sums[r * width() + i];
        largest_sum = std::max(largest_sum, sum);
      }
    }
    if (largest_sum > 0) limit_ = static_cast<std::int32_t>(std::min<std::uint32_t>(limit_, INT32_MAX / largest_sum));
  }

  std::uint32_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }

  // The largest quantised input for which no sum of a row can overflow 32 bits; at least 1 if columns() <=
  // max_row_inputs.
  std::int32_t limit() const { return limit_; }

  std::uint32_t panel_rows() const { return form_ == Form::quads ? quad_panel_rows : column_panel_rows; }
  // Rows of the panel that begins at row `first`, a multiple of panel_rows().
  std::uint32_t rows_at(std::uint32_t first) const { return std::min(panel_rows(), rows_ - first); }

  // The rows of that panel; output.rows begin with it.
  void multiply(std::uint32_t first, const PanelInputs& inputs, const PanelOutput& output) const {
    const std::size_t stride = stored_rows(first) * width();
    (form_ == Form::quads ? kernels_->quad_product : kernels_->column_product)({panel(first), rows_at(first), stride},
                                                                               inputs, output);
  }

  // Where a column of a matrix of Form::columns begins in every panel, and which column that is.
  std::uint32_t offset(std::size_t column) const { return static_cast<std::uint32_t>(column) * column_length_; }
  std::size_t column_at(std::uint32_t offset) const { return offset / column_length_; }

  // Prefetches the column at an offset.
  void prefetch(std::uint32_t offset) const {
    if (!has_prefetch) return;
    for (std::uint32_t first = 0; first < rows_; first += column_panel_rows)
      for (std::uint32_t r = 0; r < rows_at(first); r += sizeof(Block)) __builtin_prefetch(panel(first) + offset + r);
  }

  int digit(std::uint32_t row, std::size_t column) const {
    return digit_at(const_cast<PanelMatrix*>(this)->at(row, column));
  }

 private:
  struct alignas(64) Block {
    std::uint8_t digit[64];
  };
  static int number(std::int16_t value, Digit digit) {
    return digit.high ? high_digit(value, digit.low_bits) : low_digit(value, digit.low_bits);
  }
  // The digits of a group of rows of a column as they are stored.
  void find_digits(const std::int16_t* values, std::uint32_t count, Digit digit, std::uint8_t* stored_digits) const {
    const auto find = [&](auto&& digit_of) {
      for (std::uint32_t r = 0; r < count; ++r)
        stored_digits[r] = static_cast<std::uint8_t>(digit_of(values[r]) + added_to_row_[r]);
    };
    if (!digit.high && digit.low_bits == 8)
      find([](std::int16_t value) { return value; });  // the bits above the digit are cut off
    else
      find([&](std::int16_t value) { return number(value, digit); });
  }
  // What is stored where.
  std::uint8_t stored(int digit, const std::uint8_t* at) const {
    return static_cast<std::uint8_t>(digit + added_at(at));
  }
  int digit_at(const std::uint8_t* at) const {
    const int added = added_at(at);
    return added == 0 ? static_cast<std::int8_t>(*at) : *at - added;
  }
  // Blocks are aligned, so that an address is odd where its place in a column is.
  int added_at(const std::uint8_t* at) const {
    const bool odd = (reinterpret_cast<std::uintptr_t>(at) & 1) != 0;
    return odd && form_ == Form::columns && kernels_->signed_odd_digits ? 0 : 128;
  }
  // Columns of a line, which is a column or a quad.
  std::size_t width() const { return form_ == Form::quads ? quad_columns : 1; }
  std::size_t stored_rows(std::uint32_t first) const {
    const std::size_t rows = form_ == Form::quads ? rows_at(first) : std::min<std::size_t>(rows_, column_panel_rows);
    const std::size_t group = form_ == Form::quads ? quad_group : column_group;
    return (rows + group - 1) / group * group;
  }
  // All panels before this one are full.
  const std::uint8_t* panel(std::uint32_t first) const {
    return reinterpret_cast<const std::uint8_t*>(blocks_.data()) + first * lines_ * width();
  }
  std::uint8_t* at(std::uint32_t row, std::size_t column) {
    const std::uint32_t first = row / panel_rows() * panel_rows();
    std::uint8_t* const line =
        const_cast<std::uint8_t*>(panel(first)) + column / width() * stored_rows(first) * width();
    const std::uint32_t r = row - first;
    if (form_ == Form::quads) return line + quad_columns * r + quad_position(column);
    return line + r / column_group * column_group + kernels_->column_rows[r % column_group];
  }

  const PoseKernels* kernels_;
  Form form_;
  std::uint32_t rows_;
  std::size_t columns_, lines_;
  std::uint32_t column_length_;  // of a stored column of Form::columns, in every panel
  std::int32_t limit_ = largest_wide;
  std::uint8_t added_to_row_[column_group];  // to the digits of a group of rows of a column
  std::pmr::vector<Block> blocks_;
};

}  // namespace fb::runtime
