#include <memory_resource>
#include <span>
#include <vector>

#include "archive/coding/coding_reader.h"
#include "archive/container/container_layout.h"

namespace fb::archive {
namespace {

void read_order(ByteReader& in, std::uint32_t vertices, std::vector<std::uint32_t>& order) {
  order = in.planes(vertices, "the order");
  std::pmr::vector<bool> listed(vertices, false, &in.budget());
  std::uint32_t vertex = 0;
  for (std::uint32_t& delta : order) {
    delta = vertex += from_zigzag(delta);
    if (vertex >= vertices || listed[vertex]) in.corrupt("the order does not list every vertex once");
    listed[vertex] = true;
  }
}

void read_block_rows(ByteReader& in, std::uint32_t vertices, PackedModel& model) {
  const auto rows = in.temporary_planes(in.count(4, "row blocks"), "row counts");
  in.budget().resize(model.row_blocks, rows.size(), "row blocks");
  std::uint64_t row = 0;
  for (std::size_t b = 0; b < rows.size(); ++b) {
    model.row_blocks[b].first_row = static_cast<std::uint32_t>(row);
    model.row_blocks[b].row_count = rows[b];
    row += rows[b];
    if (row > 3 * std::uint64_t(vertices)) break;
  }
  if (row != 3 * std::uint64_t(vertices)) in.corrupt("row blocks do not add up to the number of rows");
}

// Makes room for the columns of each row block. `counts`: of the segments of each column; `deltas`: from row block to
// row block of a column's segments.
void reserve_columns(ByteReader& in, std::span<const std::uint32_t> counts, std::span<const std::uint32_t> deltas,
                     PackedModel& model) {
  std::pmr::vector<std::uint32_t> columns(model.row_blocks.size(), &in.budget());
  std::size_t at = 0;
  for (const std::uint32_t count : counts) {
    std::uint64_t block = 0;
    for (std::uint32_t i = 0; i < count; ++i, ++at) {
      if (i > 0 && deltas[at] == 0) in.corrupt("a column lies twice in one row block");
      block += deltas[at];
      if (block >= columns.size()) in.corrupt("a column lies in a row block that does not exist");
      ++columns[block];
    }
  }
  for (std::size_t b = 0; b < columns.size(); ++b)
    in.budget().reserve(model.row_blocks[b].columns, columns[b], "columns");
}

// The columns of the row blocks, stored column by column. Returns the class table of each segment.
SegmentTables read_segments(ByteReader& in, PackedModel& model) {
  const auto counts = in.temporary_planes(model.columns, "segment counts");
  std::uint64_t segments = 0;
  for (const std::uint32_t count : counts) segments += count;
  const auto deltas = in.temporary_planes(segments, "row blocks of segments");
  auto flags = in.temporary_numbers<std::uint8_t>(segments, "flags");
  const auto scales = in.temporary_float_planes(in.count(4, "scales"), "scales");
  in.end();

  reserve_columns(in, counts, deltas, model);
  std::size_t at = 0, next_scale = 0;
  for (std::uint32_t c = 0; c < model.columns; ++c) {
    std::uint64_t block = 0;
    for (std::uint32_t i = 0; i < counts[c]; ++i, ++at) {
      block += deltas[at];
      if (flags[at] & segment_new_scale_flag) ++next_scale;
      if (next_scale == 0 || next_scale > scales.size()) in.corrupt("a column has no scale");
      model.row_blocks[block].columns.push_back({c, (flags[at] & segment_16_bit_flag) != 0, scales[next_scale - 1]});
      flags[at] >>= segment_table_shift;
    }
  }
  if (next_scale != scales.size()) in.corrupt("there are more scales than columns use");
  return flags;
}

}  // namespace

SegmentTables read_basis(ByteReader& in, std::uint32_t vertices, PackedModel& model) {
  model.columns = in.count(4, "columns");
  const auto ordered = in.number<std::uint32_t>("the order flag");
  if (ordered > 1) in.corrupt("the order flag is neither 0 nor 1");
  if (ordered) read_order(in, vertices, model.order);
  read_block_rows(in, vertices, model);
  return read_segments(in, model);
}

}  // namespace fb::archive
