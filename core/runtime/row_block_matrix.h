#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <utility>
#include <vector>

#include "model/packed_model.h"
#include "runtime/panel_matrix.h"
#include "runtime/quantise.h"

namespace fb::runtime {

// A row block of the basis, laid out for evaluation as a matrix of digits. A matrix column has the values or low digits
// of a basis column, or the high digits of a wide one; its input is coefficient column(i) times scale(i). The columns
// of values and low digits come first; in both parts basis columns ascend.
class RowBlockMatrix {
 public:
  RowBlockMatrix(const PoseKernels& kernels, const PackedRowBlock& block, std::pmr::memory_resource& memory);

  std::uint32_t first_row() const { return first_row_; }
  std::uint32_t row_count() const { return digits_.rows(); }
  std::size_t column_count() const { return column_count_; }   // of the basis, used by this block
  std::size_t input_count() const { return columns_.size(); }  // matrix columns
  std::uint32_t column(std::size_t input) const { return columns_[input]; }
  float scale(std::size_t input) const { return scales_[input]; }
  int digit(std::uint32_t row, std::size_t input) const { return digits_.digit(row, input); }

  // Inputs begin..end - 1.
  struct InputRange {
    std::uint32_t begin, end;
  };
  // The inputs of basis columns first_column..last_column - 1 in both parts; the second is empty without wide columns.
  std::pair<InputRange, InputRange> inputs_of(std::uint32_t first_column, std::uint32_t last_column) const;

  // inputs[i * poses + p] = coefficient column(i) of pose p times scale(i), for a range. Coefficients of poses are
  // interleaved likewise.
  template <std::size_t poses>
  void scale_coefficients(InputRange range, const float* coefficients, float* inputs) const {
    for (std::uint32_t i = range.begin; i < range.end; ++i, inputs += poses)
      for (std::size_t p = 0; p < poses; ++p) inputs[p] = coefficients[columns_[i] * poses + p] * scales_[i];
  }

  // See PanelMatrix::offset.
  std::uint32_t offset(std::size_t input) const { return digits_.offset(input); }

  // The input at such an offset.
  std::size_t input_at(std::uint32_t offset) const { return digits_.column_at(offset); }

  // Prefetches matrix columns: which ones a pose uses is unpredictable to the hardware.
  void prefetch(const std::uint32_t* offsets, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i) digits_.prefetch(offsets[i]);
  }

  // See PanelMatrix::limit.
  float limit() const { return static_cast<float>(digits_.limit()); }

  // rows[p] = rest + displacements of pose p, row_count() floats.
  void run(const QuantisedInputs& inputs, const float* rest, float* const* rows) const;

  // The displacements for one unit of the coefficient of basis column `input` < column_count(): row_count() floats, or
  // that of one row.
  void displacements(std::size_t input, float* values) const;
  float displacement(std::size_t input, std::uint32_t row) const;

 private:
  // The matrix columns of a basis column's low and high digits; base 0: it has no high ones.
  struct Digits {
    std::size_t low, high;
    int base;
  };
  Digits find_digits(std::size_t input) const;
  float value(const Digits& digits, std::uint32_t row) const;

  std::uint32_t first_row_;
  std::size_t column_count_;
  std::pmr::vector<std::uint32_t> columns_;  // of the basis, by matrix column
  std::pmr::vector<float> scales_;
  std::pmr::vector<std::uint8_t> wide_bits_;  // of low digits, of each wide column
  PanelMatrix digits_;
};

}  // namespace fb::runtime
