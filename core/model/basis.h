#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fb {

// Consecutive rows (coordinates) that use the same coefficients.
struct RowGroup {
  std::uint32_t first_row = 0, row_count = 0;
  std::vector<std::uint32_t> columns;  // the coefficients used, ascending
  std::vector<float> values;           // column after column, row_count numbers each
};

// The fixed blendshapes: displacement[row] = sum of value * coefficient, block-sparse. Row 3 i + axis is coordinate
// `axis` of a vertex. One column list for all rows is global PCA; short lists are local bases and sparse shapes.
struct Basis {
  std::uint32_t rows = 0, columns = 0;
  std::vector<RowGroup> groups;  // ascending, without gaps or overlaps, covering all rows
  // Row 3 i + axis is coordinate `axis` of vertex order[i], so that rows which use the same columns lie together;
  // empty: of vertex i.
  std::vector<std::uint32_t> order = {};

  std::size_t value_count() const;
};

// Rows of a group unless stated otherwise.
inline constexpr std::uint32_t basis_group_rows = 64;

// Cuts a dense basis, given column after column (columns x rows), into groups; a column that is 0 on a whole group is
// left out of it.
Basis make_basis(std::uint32_t rows, std::uint32_t columns, const std::vector<float>& dense);

// Fails, naming the group, unless groups cover all rows in order, columns ascend and exist, values are finite, and the
// order is one.
void check(const Basis& basis);

// Fails unless `order` is empty or names each of rows / 3 vertices once.
void check_order(const std::vector<std::uint32_t>& order, std::size_t rows);

}  // namespace fb
