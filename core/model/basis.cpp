#include "model/basis.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"
#include "base/status.h"

namespace fb {

std::size_t Basis::value_count() const {
  std::size_t count = 0;
  for (const RowBlock& block : row_blocks) count += block.values.size();
  return count;
}

Basis make_basis(std::uint32_t rows, std::uint32_t columns, const std::vector<float>& dense) {
  if (dense.size() != checked_multiply(rows, columns, "basis"))
    fail(Status::invalid_argument, "a basis of %u x %u is given %zu values", rows, columns, dense.size());
  Basis basis{rows, columns, {}, {}};
  for (std::uint32_t first = 0; first < rows; first += default_block_rows) {
    RowBlock block{first, std::min(default_block_rows, rows - first), {}, {}};
    for (std::uint32_t column = 0; column < columns; ++column) {
      const float* values = dense.data() + std::size_t(column) * rows + first;
      if (std::all_of(values, values + block.row_count, [](float v) { return v == 0; })) continue;
      block.columns.push_back(column);
      block.values.insert(block.values.end(), values, values + block.row_count);
    }
    basis.row_blocks.push_back(std::move(block));
  }
  return basis;
}

void check(const Basis& basis) {
  std::size_t row = 0;
  for (std::size_t i = 0; i < basis.row_blocks.size(); ++i) {
    const RowBlock& block = basis.row_blocks[i];
    if (block.first_row != row || block.row_count == 0)
      fail(Status::bad_data, "basis: row block %zu begins at row %u, not %zu, or is empty", i, block.first_row, row);
    row += block.row_count;
    for (std::size_t c = 0; c < block.columns.size(); ++c)
      if (block.columns[c] >= basis.columns || (c > 0 && block.columns[c] <= block.columns[c - 1]))
        fail(Status::bad_data, "basis: row block %zu lists column %u out of order or range", i, block.columns[c]);
    if (block.values.size() != checked_multiply(block.columns.size(), block.row_count, "basis row block"))
      fail(Status::bad_data, "basis: row block %zu has %zu values for %zu columns of %u rows", i, block.values.size(),
           block.columns.size(), block.row_count);
    for (const float value : block.values)
      if (!std::isfinite(value)) fail(Status::not_finite, "basis: row block %zu holds a value that is not finite", i);
  }
  if (row != basis.rows) fail(Status::bad_data, "basis: row blocks cover %zu of %u rows", row, basis.rows);
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
