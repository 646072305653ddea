#include "runtime/panel_matrix.h"

#include <algorithm>
#include <numeric>

#include "base/checked.h"

namespace fb {
namespace {

std::size_t panels_of(std::uint32_t rows) {
  return (std::size_t(rows) + 63) / 64;
}
std::size_t lines_of(std::uint32_t rows) {
  return (std::size_t(rows) + 15) / 16;
}

}  // namespace

PanelMatrix::PanelMatrix(const DenseLayer& layer, std::pmr::memory_resource& memory)
    : panels_(&memory), lists_(&memory), columns_(&memory), lines_(&memory) {
  reserve(panels_of(layer.outputs), 1, layer.inputs,
          checked_multiply(lines_of(layer.outputs), layer.inputs, "a layer's lines"));
  std::vector<std::uint32_t> all(layer.inputs);
  std::iota(all.begin(), all.end(), 0);
  const std::uint32_t list = add_list(all);
  for (std::uint32_t first = 0; first < layer.outputs; first += panel_rows)
    add_panel(first, std::min(panel_rows, layer.outputs - first), list, [&](std::size_t row, std::size_t column) {
      return layer.weights[(first + row) * layer.inputs + column];
    });
}

PanelMatrix::PanelMatrix(const Basis& basis, std::pmr::memory_resource& memory)
    : panels_(&memory), lists_(&memory), columns_(&memory), lines_(&memory) {
  const auto same_list = [&](std::size_t g) { return g > 0 && basis.groups[g].columns == basis.groups[g - 1].columns; };
  std::size_t panels = 0, lists = 0, columns = 0, lines = 0;
  for (std::size_t g = 0; g < basis.groups.size(); ++g) {
    const RowGroup& group = basis.groups[g];
    panels += panels_of(group.row_count);
    lines = checked_add(lines, checked_multiply(lines_of(group.row_count), group.columns.size(), "a row group's lines"),
                        "the basis' lines");
    if (same_list(g)) continue;
    ++lists;
    columns += group.columns.size();
  }
  reserve(panels, lists, columns, lines);
  std::uint32_t list = 0;
  for (std::size_t g = 0; g < basis.groups.size(); ++g) {
    const RowGroup& group = basis.groups[g];
    if (!same_list(g)) list = add_list(group.columns);
    for (std::uint32_t first = 0; first < group.row_count; first += panel_rows)
      add_panel(
          group.first_row + first, std::min(panel_rows, group.row_count - first), list,
          [&](std::size_t row, std::size_t column) { return group.values[column * group.row_count + first + row]; });
  }
}

void PanelMatrix::reserve(std::size_t panels, std::size_t lists, std::size_t columns, std::size_t lines) {
  panels_.reserve(panels);
  lists_.reserve(lists);
  columns_.reserve(columns);
  lines_.reserve(lines);
}

std::uint32_t PanelMatrix::add_list(std::span<const std::uint32_t> columns) {
  lists_.push_back({columns_.size(), checked_u32(columns.size(), "columns of a panel")});
  columns_.insert(columns_.end(), columns.begin(), columns.end());
  return checked_u32(lists_.size() - 1, "column lists");
}

template <class Value>
void PanelMatrix::add_panel(std::uint32_t first_row, std::uint32_t row_count, std::uint32_t list, Value&& value) {
  panels_.push_back({first_row, row_count, list, lines_.size()});
  for (std::size_t column = 0; column < lists_[list].count; ++column)
    for (std::size_t row = 0; row < row_count; row += 16) {
      Line line = {};
      for (std::size_t lane = 0; lane < 16 && row + lane < row_count; ++lane)
        line.value[lane] = value(row + lane, column);
      lines_.push_back(line);
    }
}

std::size_t PanelMatrix::longest_list() const {
  std::size_t longest = 0;
  for (const List& list : lists_) longest = std::max<std::size_t>(longest, list.count);
  return longest;
}

std::span<const ActiveColumn> PanelMatrix::list_active(const List& list, const float* input,
                                                       std::span<ActiveColumn> active) const {
  const std::uint32_t* columns = columns_.data() + list.first;
  std::size_t used = 0;
  // Written whether used or not: whether an activation is 0 is a coin toss no branch predictor wins.
  for (std::uint32_t place = 0; place < list.count; ++place) {
    active[used] = {place, input[columns[place]]};
    used += active[used].input != 0;
  }
  return active.first(used);
}

void PanelMatrix::accumulate(const Panel& panel, std::span<const ActiveColumn> used, float* sums) const {
  const std::size_t lines = panel.lines();
  const Line* values = lines_.data() + panel.values;
  std::fill_n(sums, panel_rows, -0.0f);
  // Four columns a pass, because at two loads and one store for each product the sums would be the bottleneck.
  std::size_t k = 0;
  for (; k + 4 <= used.size(); k += 4) {
    const float x0 = used[k].input, x1 = used[k + 1].input, x2 = used[k + 2].input, x3 = used[k + 3].input;
    const Line* column0 = values + used[k].place * lines;
    const Line* column1 = values + used[k + 1].place * lines;
    const Line* column2 = values + used[k + 2].place * lines;
    const Line* column3 = values + used[k + 3].place * lines;
    for (std::size_t line = 0; line < lines; ++line)
      for (std::size_t lane = 0; lane < 16; ++lane) {
        float& sum = sums[16 * line + lane];
        sum = (((sum + x0 * column0[line].value[lane]) + x1 * column1[line].value[lane]) +
               x2 * column2[line].value[lane]) +
              x3 * column3[line].value[lane];
      }
  }
  for (; k < used.size(); ++k) {
    const float x = used[k].input;
    const Line* column = values + used[k].place * lines;
    for (std::size_t line = 0; line < lines; ++line)
      for (std::size_t lane = 0; lane < 16; ++lane) sums[16 * line + lane] += x * column[line].value[lane];
  }
}

}  // namespace fb
