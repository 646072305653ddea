// The one matrix form of the runtime: dense layers and the basis are both multiplied with a vector through it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/basis.h"
#include "model/network.h"

namespace fb {

// A column of the matrix whose input is not 0: its place in the panel's list of columns, and that input.
struct ActiveColumn {
  std::uint32_t place;
  float input;
};

// Rows in panels of at most 64, each with the list of columns it uses; a panel's values lie column after column, rows
// side by side, so that a loop over rows is a loop over lanes and a column whose input is 0 is never read.
// Every row is summed over its columns in ascending order, each product rounded, starting from -0 (which a sum of
// nothing keeps, so that rest + displacement leaves rest alone to the last bit). The bits do not depend on the vector
// width.
class PanelMatrix {
 public:
  static constexpr std::uint32_t panel_rows = 64;

  PanelMatrix(const DenseLayer& layer, std::pmr::memory_resource& memory);
  PanelMatrix(const Basis& basis, std::pmr::memory_resource& memory);

  // The number of active columns multiply may list.
  std::size_t longest_list() const;

  // Calls finish(first_row, row_count, sums) for each panel in the order of rows; sums is row_count floats. `active` is
  // working memory of at least longest_list() entries.
  template <class Finish>
  void multiply(const float* input, std::span<ActiveColumn> active, Finish&& finish) const {
    std::uint32_t listed = UINT32_MAX;
    std::span<const ActiveColumn> used;
    for (const Panel& panel : panels_) {
      if (panel.list != listed) used = list_active(lists_[panel.list], input, active);
      listed = panel.list;
      alignas(64) float sums[panel_rows];
      accumulate(panel, used, sums);
      finish(panel.first_row, panel.row_count, static_cast<const float*>(sums));
    }
  }

 private:
  struct alignas(64) Line {
    float value[16];
  };
  struct List {
    std::size_t first;  // in columns_
    std::uint32_t count;
  };
  struct Panel {
    std::uint32_t first_row, row_count, list;
    std::size_t values;  // in lines_
    std::uint32_t lines() const { return (row_count + 15) / 16; }
  };

  void reserve(std::size_t panels, std::size_t lists, std::size_t columns, std::size_t lines);
  std::uint32_t add_list(std::span<const std::uint32_t> columns);
  // value(row of the panel, column of the list)
  template <class Value>
  void add_panel(std::uint32_t first_row, std::uint32_t row_count, std::uint32_t list, Value&& value);
  std::span<const ActiveColumn> list_active(const List& list, const float* input, std::span<ActiveColumn> active) const;
  void accumulate(const Panel& panel, std::span<const ActiveColumn> used, float* sums) const;

  std::pmr::vector<Panel> panels_;
  std::pmr::vector<List> lists_;
  std::pmr::vector<std::uint32_t> columns_;
  std::pmr::vector<Line> lines_;
};

}  // namespace fb
