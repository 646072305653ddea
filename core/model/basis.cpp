#include "model/basis.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"
#include "base/status.h"

namespace fb {

std::size_t Basis::value_count() const {
  std::size_t count = 0;
  for (const RowGroup& group : groups) count += group.values.size();
  return count;
}

Basis make_basis(std::uint32_t rows, std::uint32_t columns, const std::vector<float>& dense) {
  if (dense.size() != checked_multiply(rows, columns, "basis"))
    fail(Status::invalid_argument, "a basis of %u x %u is given %zu values", rows, columns, dense.size());
  Basis basis{rows, columns, {}, {}};
  for (std::uint32_t first = 0; first < rows; first += basis_group_rows) {
    RowGroup group{first, std::min(basis_group_rows, rows - first), {}, {}};
    for (std::uint32_t column = 0; column < columns; ++column) {
      const float* values = dense.data() + std::size_t(column) * rows + first;
      if (std::all_of(values, values + group.row_count, [](float v) { return v == 0; })) continue;
      group.columns.push_back(column);
      group.values.insert(group.values.end(), values, values + group.row_count);
    }
    basis.groups.push_back(std::move(group));
  }
  return basis;
}

void check(const Basis& basis) {
  std::size_t row = 0;
  for (std::size_t g = 0; g < basis.groups.size(); ++g) {
    const RowGroup& group = basis.groups[g];
    if (group.first_row != row || group.row_count == 0)
      fail(Status::bad_data, "basis: row group %zu begins at row %u, not %zu, or is empty", g, group.first_row, row);
    row += group.row_count;
    for (std::size_t c = 0; c < group.columns.size(); ++c)
      if (group.columns[c] >= basis.columns || (c > 0 && group.columns[c] <= group.columns[c - 1]))
        fail(Status::bad_data, "basis: row group %zu lists column %u out of order or range", g, group.columns[c]);
    if (group.values.size() != checked_multiply(group.columns.size(), group.row_count, "basis row group"))
      fail(Status::bad_data, "basis: row group %zu has %zu values for %zu columns of %u rows", g, group.values.size(),
           group.columns.size(), group.row_count);
    for (const float value : group.values)
      if (!std::isfinite(value)) fail(Status::not_finite, "basis: row group %zu holds a value that is not finite", g);
  }
  if (row != basis.rows) fail(Status::bad_data, "basis: row groups cover %zu of %u rows", row, basis.rows);
  check_order(basis.order, basis.rows);
}

void check_order(const std::vector<std::uint32_t>& order, std::size_t rows) {
  if (order.empty()) return;
  if (3 * order.size() != rows)
    fail(Status::bad_data, "basis: the order has %zu vertices for %zu rows", order.size(), rows);
  std::vector<bool> seen(order.size());
  for (const std::uint32_t vertex : order) {
    if (vertex >= order.size() || seen[vertex])
      fail(Status::bad_data, "basis: the order names vertex %u twice or beyond the last", vertex);
    seen[vertex] = true;
  }
}

}  // namespace fb
