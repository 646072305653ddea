// A row group of the basis, laid out for speed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <vector>

#include "model/packed_model.h"
#include "runtime/kernels/panel_kernels.h"
#include "runtime/panel_matrix.h"
#include "runtime/quantized.h"

namespace fb::runtime {

// Summand s is coefficient column(s) times scale(s); a wide column has two, one for each digit. Every column's values
// or low digits come first, then the high digits of wide columns; in both parts columns ascend.
class RowBlockMatrix {
 public:
  RowBlockMatrix(const PackedRowBlock& group, std::pmr::memory_resource& memory);

  std::uint32_t first_row() const { return first_row_; }
  std::uint32_t row_count() const { return digits_.rows(); }
  std::size_t summand_count() const { return columns_.size(); }
  std::uint32_t column(std::size_t summand) const { return columns_[summand]; }
  float scale(std::size_t summand) const { return scales_[summand]; }

  // The summands that use columns first_column and on, up to last_column: begin..end.
  struct Span {
    std::uint32_t begin, end;
  };
  // Of both parts; the second is empty if there is no wide column.
  std::pair<Span, Span> summands_of(std::uint32_t first_column, std::uint32_t last_column) const;

  // coefficients[column(s)] * scale(s) for the summands of a span, those of poses side by side.
  template <std::size_t poses>
  void weigh(Span span, const float* coefficients, float* summands) const {
    for (std::uint32_t s = span.begin; s < span.end; ++s, summands += poses)
      for (std::size_t p = 0; p < poses; ++p) summands[p] = coefficients[columns_[s] * poses + p] * scales_[s];
  }

  // Asks the processor for the digits of these summands: which are needed next no prefetcher can prediction.
  void fetch(const std::uint32_t* places, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i) digits_.fetch(places[i]);
  }

  // The largest number that summands may be rounded to.
  float limit() const { return static_cast<float>(digits_.limit()); }

  // rows[pose] = rest + what the pose's summands, those at their places, move. Rows are left alone where all are 0.
  void run(const PoseKernels& kernels, const Quantized& summands, const float* rest, float* const* rows) const;

  // What one unit of a column's coefficient moves: row_count() floats. `place` is that of its value or low digit.
  void displacements(std::size_t place, float* moved) const;
  std::size_t column_count() const { return column_count_; }

 private:
  std::uint32_t first_row_;
  std::size_t column_count_;
  std::pmr::vector<std::uint32_t> columns_;
  std::pmr::vector<float> scales_;
  PanelMatrix digits_;
};

}  // namespace fb::runtime
