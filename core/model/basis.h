#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace fb {

// Consecutive rows (vertex coordinates) that use the same coefficients.
struct RowBlock {
  std::uint32_t first_row = 0, row_count = 0;
  std::vector<std::uint32_t> columns;  // the coefficients used, ascending
  std::vector<float> values;           // column-major: row_count values a column
};

// The linear output layer: displacement[row] = sum over columns of value * coefficient, block-sparse. Row blocks that
// all list the same columns make a global PCA basis; short lists make local bases and sparse blendshapes.
struct Basis {
  std::uint32_t rows = 0, columns = 0;
  std::vector<RowBlock> row_blocks;  // ascending, without gaps or overlaps, covering all rows
  // Row 3 i + axis is coordinate `axis` of vertex order[i] (baked order: vertices that use the same columns are
  // contiguous); empty: of vertex i.
  std::vector<std::uint32_t> order = {};

  std::size_t value_count() const;
};

// Rows of a block unless stated otherwise.
inline constexpr std::uint32_t default_block_rows = 64;

// Cuts a dense column-major basis (columns x rows) into blocks of default_block_rows rows; a column that is 0 on all
// rows of a block is omitted from it.
Basis make_basis(std::uint32_t rows, std::uint32_t columns, const std::vector<float>& dense);

// Fails, naming the row block, unless blocks cover all rows in order, columns ascend and exist, values are finite, and
// the order is a permutation of the vertices.
void check(const Basis& basis);

// Fails unless `order` is empty or a permutation of rows / 3 vertices.
void check_order(const std::vector<std::uint32_t>& order, std::size_t rows);

}  // namespace fb
