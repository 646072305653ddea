#include "archive/coding/coding_units.h"

#include <algorithm>
#include <functional>
#include <queue>
#include <utility>

namespace fb::archive {
namespace {

constexpr std::uint32_t no_vertex = 0xffffffff, unset = 0xffffffff;

// The neighbours of each vertex along polygon edges, at most `max_neighbours`, and when each vertex was coded last.
class VertexNeighbours {
 public:
  VertexNeighbours(const Mesh& mesh, std::uint32_t vertices, std::pmr::memory_resource& memory)
      : count_(vertices, &memory), list_(vertices, &memory), time_(vertices, &memory), coded_count_(vertices, &memory) {
    std::size_t at = 0;
    for (const std::uint32_t size : mesh.polygon_sizes) {
      for (std::uint32_t k = 0; k < size; ++k)
        connect(mesh.polygon_corners[at + k], mesh.polygon_corners[at + (k + 1) % size]);
      at += size;
    }
  }

  std::span<const std::uint32_t> of(std::uint32_t vertex) const { return {list_[vertex].data(), count_[vertex]}; }
  bool is_coded(std::uint32_t vertex) const { return time_[vertex] > 0; }
  // When a vertex was coded last, counted in coding units; 0: not yet.
  std::uint32_t time(std::uint32_t vertex) const { return time_[vertex]; }
  void set_coded(std::uint32_t vertex) {
    if (!is_coded(vertex))
      for (const std::uint32_t w : of(vertex)) ++coded_count_[w];
    time_[vertex] = ++now_;
  }
  // The coded neighbours of a vertex.
  std::uint32_t coded_count(std::uint32_t vertex) const { return coded_count_[vertex]; }

  static constexpr std::size_t max_neighbours = 16;

 private:
  bool connected(std::uint32_t v, std::uint32_t w) const {
    const auto list = of(v);
    return std::find(list.begin(), list.end(), w) != list.end();
  }
  void connect(std::uint32_t v, std::uint32_t w) {
    if (v == w || count_[v] == max_neighbours || count_[w] == max_neighbours || connected(v, w)) return;
    list_[v][count_[v]++] = w;
    list_[w][count_[w]++] = v;
  }

  std::pmr::vector<std::uint8_t> count_;
  std::pmr::vector<std::array<std::uint32_t, max_neighbours>> list_;
  std::pmr::vector<std::uint32_t> time_;
  std::pmr::vector<std::uint8_t> coded_count_;
  std::uint32_t now_ = 0;
};

// Ranks vertices and finds the candidate predictors of coding units.
class PredictorFinder {
  static constexpr std::size_t most_predicting = 4;  // coded neighbours

 public:
  PredictorFinder(std::uint32_t vertices, std::pmr::memory_resource& memory)
      : ranks_(vertices, unset, &memory), surroundings_(vertices, &memory), no_rank_(vertices) {}

  // Sets the unit's rank and returns its candidates, valid until the next call.
  std::span<const Predictor> find(std::uint32_t vertex, const VertexNeighbours& mesh, CodingUnit& unit) {
    coded_.clear();  // the neighbour coded last first
    for (const std::uint32_t w : mesh.of(vertex))
      if (mesh.is_coded(w)) coded_.push_back(w);
    std::sort(coded_.begin(), coded_.end(), [&](auto v, auto w) { return mesh.time(v) > mesh.time(w); });
    unit.rank = rank(vertex);
    coded_.resize(std::min<std::size_t>(coded_.size(), most_predicting));

    candidates_.clear();
    find_surroundings(vertex, mesh);
    find_beyond(mesh);
    add_parallelograms();
    if (coded_.empty()) candidates_.push_back({no_rank_, no_rank_, no_rank_});
    for (std::size_t i = 0; i < coded_.size() && i < 2; ++i)
      candidates_.push_back({ranks_[coded_[i]], no_rank_, no_rank_});
    add_extrapolations();
    unit.predictor_count = static_cast<std::uint8_t>(candidates_.size());
    return candidates_;
  }

 private:
  std::uint32_t rank(std::uint32_t vertex) {
    if (ranks_[vertex] == unset) ranks_[vertex] = next_rank_++;
    return ranks_[vertex];
  }

  // Counts, for the vertices around the neighbours of `vertex`, how many of these neighbours they are next to.
  void find_surroundings(std::uint32_t vertex, const VertexNeighbours& mesh) {
    ++now_;
    for (const std::uint32_t u : mesh.of(vertex))
      for (const std::uint32_t w : mesh.of(u)) {
        const std::uint32_t before = surroundings_[w].time == now_ ? surroundings_[w].neighbours : 0;
        surroundings_[w] = {now_, before + 1};
      }
    for (const std::uint32_t u : mesh.of(vertex)) surroundings_[u] = {now_, 0};
    surroundings_[vertex] = {now_, 0};
  }
  // Finds, of the vertices next to each coded neighbour that are coded, and neither `vertex` nor a neighbour of it,
  // those next to several neighbours, and the one coded last of those next to this neighbour alone.
  void find_beyond(const VertexNeighbours& mesh) {
    for (std::size_t i = 0; i < coded_.size(); ++i) {
      Beyond& beyond = beyond_[i];
      beyond.shared_count = 0;
      beyond.alone = {no_vertex, 0};
      for (const std::uint32_t w : mesh.of(coded_[i])) {
        const Surroundings& around = surroundings_[w];
        const std::uint32_t time = mesh.time(w);
        if (around.neighbours == 0 || time == 0) continue;
        if (around.neighbours > 1)
          beyond.shared[beyond.shared_count++] = {w, time};
        else if (time > beyond.alone.time)
          beyond.alone = {w, time};
      }
    }
  }

  // Two coded neighbours and a vertex across the edge between them, which both are next to: the one coded last.
  void add_parallelograms() {
    for (std::size_t i = 0; i < coded_.size(); ++i)
      for (std::size_t j = i + 1; j < coded_.size(); ++j) {
        CodedVertex across = {no_vertex, 0};
        for (const CodedVertex& first : beyond_[i].all_shared())
          for (const CodedVertex& second : beyond_[j].all_shared())
            if (first.vertex == second.vertex && first.time > across.time) across = first;
        if (across.vertex != no_vertex)
          candidates_.push_back({ranks_[coded_[i]], ranks_[coded_[j]], ranks_[across.vertex]});
      }
  }

  // Linear extrapolation along an edge loop: a coded neighbour and the vertex beyond it.
  void add_extrapolations() {
    for (std::size_t i = 0; i < coded_.size(); ++i)
      if (const std::uint32_t alone = beyond_[i].alone.vertex; alone != no_vertex)
        candidates_.push_back({ranks_[coded_[i]], ranks_[coded_[i]], ranks_[alone]});
  }

  struct CodedVertex {
    std::uint32_t vertex, time;
  };
  // What lies beyond a coded neighbour.
  struct Beyond {
    std::array<CodedVertex, VertexNeighbours::max_neighbours> shared;
    std::size_t shared_count;
    CodedVertex alone;
    std::span<const CodedVertex> all_shared() const { return {shared.data(), shared_count}; }
  };

  struct Surroundings {
    std::uint32_t time;        // of find_surroundings; else the rest is of a vertex before
    std::uint32_t neighbours;  // of the vertex, next to this one; 0: it is the vertex itself or one of its neighbours
  };

  std::pmr::vector<std::uint32_t> ranks_;
  std::pmr::vector<Surroundings> surroundings_;
  std::uint32_t no_rank_, next_rank_ = 0, now_ = 0;
  std::vector<std::uint32_t> coded_;                 // neighbours of the current vertex
  std::array<Beyond, most_predicting> beyond_ = {};  // by coded neighbour
  std::vector<Predictor> candidates_;
};

struct UnitOfVertex {
  std::uint32_t vertex;
  CodingUnit unit;
};

// The units of a row block in the order of rows; rank and predictors are not set.
std::pmr::vector<UnitOfVertex> units_in_row_order(const PackedRowBlock& block, const std::vector<std::uint32_t>& order,
                                                  std::pmr::memory_resource& memory) {
  std::pmr::vector<UnitOfVertex> units(&memory);
  units.reserve(block.row_count / 3 + 2);
  for (std::uint32_t row = 0; row < block.row_count;) {
    const std::uint32_t at = block.first_row + row;
    CodingUnit unit;
    unit.row = row;
    unit.axis = static_cast<std::uint8_t>(at % 3);
    unit.count = static_cast<std::uint8_t>(std::min<std::uint32_t>(3 - unit.axis, block.row_count - row));
    row += unit.count;
    units.push_back({order.empty() ? at / 3 : order[at / 3], unit});
  }
  return units;
}

}  // namespace

void set_predictors(CodingUnit& unit, std::span<const Predictor> candidates, std::uint32_t pair) {
  std::uint32_t second = 0;
  while (pair_index(0, second + 1) <= pair) ++second;
  unit.predictor_pair = static_cast<std::uint8_t>(pair);
  unit.predictors = {candidates[pair - pair_index(0, second)], candidates[second]};
}

CodingUnits coding_units(const Mesh& mesh, std::uint32_t vertices, const std::vector<std::uint32_t>& order,
                         const std::vector<PackedRowBlock>& blocks, const SelectPredictors& select,
                         std::pmr::memory_resource& memory) {
  VertexNeighbours neighbours(mesh, vertices, memory);
  PredictorFinder finder(vertices, memory);
  // Index into `units` of each vertex not yet coded in this block.
  std::pmr::vector<std::uint32_t> waiting(vertices, unset, &memory);
  CodingUnits units_of_blocks(&memory);
  units_of_blocks.reserve(blocks.size());
  for (const PackedRowBlock& block : blocks) {
    const std::pmr::vector<UnitOfVertex> units = units_in_row_order(block, order, memory);
    // The next unit is the one with the most coded neighbours; of several, the first in row order. When a count grows,
    // the unit is queued again; later entries of a coded unit are skipped.
    using Entry = std::pair<std::uint32_t, std::uint32_t>;  // coded neighbours, units.size() - index
    std::priority_queue<Entry, std::pmr::vector<Entry>> queue(std::less<Entry>(), &memory);
    const auto size = static_cast<std::uint32_t>(units.size());
    for (std::uint32_t u = 0; u < size; ++u) {
      waiting[units[u].vertex] = u;
      queue.push({neighbours.coded_count(units[u].vertex), size - u});
    }
    auto& coded = units_of_blocks.emplace_back();
    coded.reserve(size);
    while (!queue.empty()) {
      auto [vertex, unit] = units[size - queue.top().second];
      queue.pop();
      if (waiting[vertex] == unset) continue;
      waiting[vertex] = unset;
      select(unit, finder.find(vertex, neighbours, unit));
      coded.push_back(unit);
      const bool first_time = !neighbours.is_coded(vertex);
      neighbours.set_coded(vertex);
      if (!first_time) continue;
      for (const std::uint32_t w : neighbours.of(vertex))
        if (waiting[w] != unset) queue.push({neighbours.coded_count(w), size - waiting[w]});
    }
  }
  return units_of_blocks;
}

ColumnSegments column_segments(const PackedModel& model, std::pmr::memory_resource& memory) {
  ColumnSegments segments(model.columns, &memory);
  for (std::uint32_t b = 0; b < model.row_blocks.size(); ++b)
    for (std::uint32_t c = 0; c < model.row_blocks[b].columns.size(); ++c)
      segments[model.row_blocks[b].columns[c].column].push_back({b, c});
  return segments;
}

std::array<std::size_t, basis_parts + 1> first_columns_of_parts(const PackedModel& model,
                                                                const ColumnSegments& segments,
                                                                std::pmr::memory_resource& memory) {
  std::pmr::vector<std::uint64_t> values_before(1, 0, &memory);  // in the columns before each
  for (const auto& column : segments) {
    std::uint64_t values = 0;
    for (const ColumnSegment& segment : column) values += model.row_blocks[segment.block].row_count;
    values_before.push_back(values_before.back() + values);
  }
  std::array<std::size_t, basis_parts + 1> first;
  first.fill(segments.size());
  std::size_t part = 0;
  for (std::size_t c = 0; c < segments.size(); ++c)
    while (part < basis_parts && basis_parts * values_before[c] >= part * values_before.back()) first[part++] = c;
  return first;
}

}  // namespace fb::archive
