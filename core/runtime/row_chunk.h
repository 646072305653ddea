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

namespace fb {

// Summand s is coefficient column(s) times scale(s); a wide column has two, one for each digit. Every column's values
// or low digits come first, then the high digits of wide columns; in both parts columns ascend.
class RowChunk {
 public:
  RowChunk(const PackedRowGroup& group, std::pmr::memory_resource& memory);

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

  // coefficients[column(s)] * scale(s) for the summands of a span.
  void weigh(Span span, const float* coefficients, float* summands) const {
    for (std::uint32_t s = span.begin; s < span.end; ++s)
      summands[s - span.begin] = coefficients[columns_[s]] * scales_[s];
  }

  // Summands whose digits are needed next: which these are no prefetcher can guess.
  struct Ahead {
    const RowChunk& chunk;
    const std::uint32_t* places;
    std::size_t count;
  };
  // Asks the processor for the digits of panel after panel of that chunk, from the one on that begins at row `first`.
  static void fetch(const Ahead& ahead, std::uint32_t first);

  // rows[pose] = rest + what the pose's summands, those at their places, move; and moved[pose] = true where any of them
  // counts. Rows are left alone where not. `ahead` is fetched meanwhile.
  void run(const PoseKernels& kernels, const PoseNumbers& summands, std::size_t poses, Quantized& quantized,
           const float* rest, float* const* rows, bool* moved, const Ahead& ahead) const;

  // What one unit of a column's coefficient moves: row_count() floats. `place` is that of its value or low digit.
  void displacements(std::size_t place, float* moved) const;
  std::size_t column_count() const { return column_count_; }

 private:
  static void fetch_panel(const Ahead& ahead, std::uint32_t first);

  std::uint32_t first_row_;
  std::size_t column_count_;
  std::pmr::vector<std::uint32_t> columns_;
  std::pmr::vector<float> scales_;
  PanelMatrix digits_;
};

}  // namespace fb
