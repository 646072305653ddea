#include "runtime/polygon_graph.h"

#include <algorithm>

#include "base/checked.h"

namespace fb::runtime {

void PolygonSums::build(const CsrTable<std::uint32_t>& at_vertex) {
  vertices_ = static_cast<std::uint32_t>(at_vertex.row_offsets.size() - 1);
  first_.resize(vertices_ + 7);
  std::size_t extra = 1;
  for (std::uint32_t v = 0; v < vertices_; ++v) extra += std::max<std::size_t>(at_vertex.row(v).size(), 4) - 4;
  extra_.reserve(extra);
  extra_begin_.reserve((vertices_ + PolygonGraph::batch - 1) / PolygonGraph::batch);
  for (std::uint32_t v = 0; v < vertices_; ++v) {
    if (v % PolygonGraph::batch == 0)
      extra_begin_.push_back(checked_u32(extra_.size(), "the polygons around the vertices of the mesh"));
    const std::span<const std::uint32_t> around = at_vertex.row(v);
    for (std::size_t k = 0; k < around.size(); ++k) {
      const std::uint32_t offset = checked_u32(4 * (std::size_t(around[k]) + 1), "the polygons of the mesh");
      if (k < 4)
        first_[v].offset[k] = offset;
      else
        extra_.push_back({v, offset});
    }
  }
  extra_.push_back({UINT32_MAX, 0});
}

PolygonsAround PolygonSums::around(std::size_t begin, std::size_t end) const {
  const auto first = static_cast<std::uint32_t>(begin * PolygonGraph::batch);
  const auto last = static_cast<std::uint32_t>(std::min<std::size_t>(end * PolygonGraph::batch, vertices_));
  return {first, last, first_.data(), extra_.data() + extra_begin_[begin]};
}

PolygonGraph::State::State(std::size_t vertices, std::size_t blocks, std::size_t polygons,
                           std::pmr::memory_resource& memory)
    : vectors(4 * (polygons + 1), &memory),
      results(3 * vertices + 25, &memory),
      moved_(blocks, &memory),
      chunks_((polygons + chunk - 1) / chunk, &memory),
      batches_((vertices + batch - 1) / batch, &memory) {}

PolygonGraph::PolygonGraph(const Mesh& mesh, std::span<const std::uint32_t> baked_index,
                           std::span<const std::uint32_t> block_rows, std::pmr::memory_resource& memory,
                           std::pmr::memory_resource& heap)
    : polygons_((mesh.polygon_sizes.size() + 1) / 2 * 2),
      blocks_(block_rows.size() - 1),
      chunk_blocks_(memory),
      batch_chunks_(memory) {
  const std::size_t chunks = (polygons_ + chunk - 1) / chunk;
  const std::size_t batches = (mesh.surface_vertex_count() + batch - 1) / batch;
  CsrBuilder<std::uint32_t> blocks(chunks, 2 * chunks, heap), around(batches, 2 * chunks, heap);
  std::pmr::vector<std::uint32_t> block_chunk(blocks_, UINT32_MAX, &heap), batch_chunk(batches, UINT32_MAX, &heap);
  const auto add = [](CsrBuilder<std::uint32_t>& table, std::size_t row, std::uint32_t entry, std::uint32_t& last,
                      std::uint32_t current) {
    if (last != current) table.add(row, entry);
    last = current;
  };
  std::size_t corner = 0;
  for (std::size_t p = 0; p < mesh.polygon_sizes.size(); ++p) {
    const auto c = static_cast<std::uint32_t>(p / chunk);
    for (const std::size_t end = corner + mesh.polygon_sizes[p]; corner < end; ++corner) {
      const std::uint32_t vertex = mesh.polygon_corners[corner];
      const std::uint32_t row = 3 * (baked_index.empty() ? vertex : baked_index[vertex]);
      auto block = static_cast<std::uint32_t>(std::upper_bound(block_rows.begin(), block_rows.end() - 1, row) -
                                              block_rows.begin() - 1);
      add(around, vertex / batch, c, batch_chunk[vertex / batch], c);
      for (; block < blocks_ && block_rows[block] < row + 3; ++block)  // a vertex may lie in two
        add(blocks, c, block, block_chunk[block], c);
    }
  }
  blocks.build(chunk_blocks_);
  around.build(batch_chunks_);
}

// Marks the chunks and batches that depend on a row block which has moved, or had in the state's last pose.
void PolygonGraph::find_changes(std::span<const std::uint8_t> moved, State& state) const {
  const bool all = state.graph_ != this;
  state.graph_ = this;
  const auto mark = [&](const CsrTable<std::uint32_t>& table, const auto& depends, std::span<std::uint8_t> marks) {
    for (std::size_t i = 0; i + 1 < table.row_offsets.size(); ++i) {
      const std::span<const std::uint32_t> row = table.row(i);
      marks[i] = all || std::any_of(row.begin(), row.end(), depends);
    }
  };
  mark(
      chunk_blocks_, [&](std::uint32_t b) { return (moved[b] | state.moved_[b]) != 0; }, state.chunks_);
  mark(
      batch_chunks_, [&](std::uint32_t c) { return state.chunks_[c] != 0; }, state.batches_);
  std::copy_n(moved.begin(), blocks_, state.moved_.begin());
}

}  // namespace fb::runtime
