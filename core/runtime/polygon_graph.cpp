#include "runtime/polygon_graph.h"

#include <algorithm>
#include <iterator>

#include "base/checked.h"

namespace fb::runtime {

void PolygonSums::build(const CsrTable<std::uint32_t>& at_vertex) {
  constexpr std::uint32_t together = FurtherPolygons::vertices;
  constexpr std::size_t first_polygons = std::size(FirstPolygons().offset);
  vertices_ = static_cast<std::uint32_t>(at_vertex.row_offsets.size() - 1);
  const auto offset = [](std::uint32_t polygon) {
    return checked_u32(no_polygon_floats + 4 * std::size_t(polygon), "the polygons of the mesh");
  };
  // Of the eight vertices from `vertex` on.
  const auto visit_further = [&](std::uint32_t vertex, const auto& visit) {
    for (std::uint32_t k = 0; k < together && vertex + k < vertices_; ++k) {
      const std::span<const std::uint32_t> around = at_vertex.row(vertex + k);
      for (std::size_t i = first_polygons; i < around.size(); ++i) visit(k, i - first_polygons, around[i]);
    }
  };
  first_.resize(vertices_ + together - 1);
  for (std::uint32_t v = 0; v < vertices_; ++v) {
    const std::span<const std::uint32_t> around = at_vertex.row(v);
    for (std::size_t k = 0; k < std::min(around.size(), first_polygons); ++k) first_[v].offset[k] = offset(around[k]);
  }
  further_begin_.reserve((vertices_ + together - 1) / together + 1);
  std::size_t further = 0;
  const auto begin = [&] {
    further_begin_.push_back(checked_u32(further, "the polygons around the vertices of the mesh"));
  };
  for (std::uint32_t v = 0; v < vertices_; v += together) {
    begin();
    std::size_t most = 0;
    visit_further(v, [&](std::uint32_t, std::size_t number, std::uint32_t) { most = std::max(most, number + 1); });
    further += most;
  }
  begin();
  FurtherPolygons none;
  std::fill_n(none.offset, together, std::uint32_t(no_polygon_floats / 2));
  further_.resize(further, none);
  for (std::uint32_t v = 0; v < vertices_; v += together)
    visit_further(v, [&](std::uint32_t vertex, std::size_t number, std::uint32_t polygon) {
      further_[further_begin_[v / together] + number].offset[vertex] = offset(polygon);
    });
}

PolygonsAround PolygonSums::around(std::size_t begin, std::size_t end) const {
  const auto first = static_cast<std::uint32_t>(begin * PolygonGraph::batch);
  const auto last = static_cast<std::uint32_t>(std::min<std::size_t>(end * PolygonGraph::batch, vertices_));
  return {first, last, first_.data(), further_.data(), further_begin_.data()};
}

PolygonGraph::State::State(std::size_t vertices, std::size_t blocks, std::size_t polygons,
                           std::pmr::memory_resource& memory)
    : vectors(no_polygon_floats + 4 * polygons, &memory),
      results(3 * vertices + 25, &memory),
      moved_(blocks, &memory),
      chunk_marks_((polygons + chunk - 1) / chunk, &memory),
      batch_marks_((vertices + batch - 1) / batch, &memory) {
  std::fill_n(vectors.begin() + no_polygon_floats / 2, no_polygon_floats / 2, -0.0f);
}

PolygonGraph::PolygonGraph(const Mesh& mesh, std::span<const std::uint32_t> baked_index,
                           std::span<const std::uint32_t> block_rows, std::pmr::memory_resource& memory,
                           std::pmr::memory_resource& heap)
    : polygons_((mesh.polygon_sizes.size() + 1) / 2 * 2),
      blocks_(block_rows.size() - 1),
      batches_((mesh.surface_vertex_count() + batch - 1) / batch),
      chunk_blocks_(memory),
      chunk_batches_(memory) {
  const std::size_t chunks = (polygons_ + chunk - 1) / chunk;
  std::pmr::vector<std::uint32_t> block_chunk(blocks_, UINT32_MAX, &heap), batch_chunk(batches_, UINT32_MAX, &heap);
  for (CsrTable<std::uint32_t>* table : {&chunk_blocks_, &chunk_batches_}) {
    table->row_offsets.reserve(chunks + 1);
    table->entries.reserve(2 * chunks);
  }
  const auto begin_row = [](CsrTable<std::uint32_t>& table) {
    table.row_offsets.push_back(checked_u32(table.entries.size(), "the row blocks of the polygons"));
  };
  std::size_t corner = 0;
  for (std::size_t p = 0; p < mesh.polygon_sizes.size(); ++p) {
    const auto c = static_cast<std::uint32_t>(p / chunk);
    if (p % chunk == 0) begin_row(chunk_blocks_), begin_row(chunk_batches_);
    const auto add = [&](CsrTable<std::uint32_t>& table, std::uint32_t entry, std::uint32_t& last_chunk) {
      if (last_chunk != c) table.entries.push_back(entry);
      last_chunk = c;
    };
    for (const std::size_t end = corner + mesh.polygon_sizes[p]; corner < end; ++corner) {
      const std::uint32_t vertex = mesh.polygon_corners[corner];
      const std::uint32_t row = 3 * (baked_index.empty() ? vertex : baked_index[vertex]);
      auto block = static_cast<std::uint32_t>(std::upper_bound(block_rows.begin(), block_rows.end() - 1, row) -
                                              block_rows.begin() - 1);
      add(chunk_batches_, vertex / batch, batch_chunk[vertex / batch]);
      for (; block < blocks_ && block_rows[block] < row + 3; ++block)  // a vertex may lie in two
        add(chunk_blocks_, block, block_chunk[block]);
    }
  }
  begin_row(chunk_blocks_);
  begin_row(chunk_batches_);
}

// Marks the chunks, and the batches around them, that depend on a row block which has moved, or had in the state's last
// pose.
void PolygonGraph::find_changes(std::span<const std::uint8_t> moved, State& state) const {
  const bool all = state.graph_ != this;
  state.graph_ = this;
  std::fill(state.batch_marks_.begin(), state.batch_marks_.end(), std::uint8_t(all));
  for (std::size_t c = 0; c < chunk_count(); ++c) {
    const std::span<const std::uint32_t> blocks = chunk_blocks_.row(c);
    state.chunk_marks_[c] = all || std::any_of(blocks.begin(), blocks.end(),
                                               [&](std::uint32_t b) { return (moved[b] | state.moved_[b]) != 0; });
    if (state.chunk_marks_[c])
      for (const std::uint32_t b : chunk_batches_.row(c)) state.batch_marks_[b] = 1;
  }
  std::copy_n(moved.begin(), blocks_, state.moved_.begin());
}

}  // namespace fb::runtime
