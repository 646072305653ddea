#include "bake/compress/mesh_blocks.h"

#include <algorithm>
#include <utility>

namespace fb::bake {
namespace {

// Rows [first, first + count) of a row block; columns that are 0 there are left out.
RowBlock rows_of(const RowBlock& block, std::uint32_t first, std::uint32_t count) {
  RowBlock part{first, count, {}, {}};
  for (std::size_t c = 0; c < block.columns.size(); ++c) {
    const auto begin = block.values.begin() + std::ptrdiff_t(c * block.row_count + (first - block.first_row));
    if (std::all_of(begin, begin + count, [](float value) { return value == 0; })) continue;
    part.columns.push_back(block.columns[c]);
    part.values.insert(part.values.end(), begin, begin + count);
  }
  return part;
}

}  // namespace

Basis cut_at_parts(Basis basis, const Mesh& rest) {
  const std::vector<std::uint32_t> ends = rest.part_ends();
  if (ends.size() < 2) return basis;
  std::vector<std::size_t> part_of;  // by vertex
  for (std::size_t part = 0; part < ends.size(); ++part) part_of.resize(ends[part], part);
  const auto part_of_row = [&](std::uint32_t row) {
    return part_of[basis.order.empty() ? row / 3 : basis.order[row / 3]];
  };
  std::vector<RowBlock> blocks;
  for (RowBlock& block : basis.row_blocks) {
    const std::uint32_t end = block.first_row + block.row_count;
    for (std::uint32_t row = block.first_row; row < end;) {
      std::uint32_t next = row + 1;
      while (next < end && part_of_row(next) == part_of_row(row)) ++next;
      if (next - row == block.row_count)
        blocks.push_back(std::move(block));
      else
        blocks.push_back(rows_of(block, row, next - row));
      row = next;
    }
  }
  basis.row_blocks = std::move(blocks);
  return basis;
}

}  // namespace fb::bake
