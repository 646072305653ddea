// What is evaluated at a level of detail.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/packed_model.h"
#include "runtime/csr_table.h"
#include "runtime/row_block_matrix.h"
#include "runtime/vertex_normals.h"
#include "runtime/vertex_tangents.h"

namespace fb::runtime {

// The inputs begin..end - 1 of a row block that are coefficients of a region.
struct RegionInputs {
  std::uint32_t region, begin, end;
};

// Where on the surface of a coarser level a vertex comes to lie: three vertices in baked order and their weights.
struct DetailPoint {
  std::array<std::uint32_t, 3> corners;
  std::array<float, 3> weights;
};

// A level of detail that is coarser than the whole.
struct DetailLevelLayout {
  // surface: the mesh of the level with its vertices in baked order. block_rows: the first row of each of its row
  // blocks, then its number of rows.
  DetailLevelLayout(const PackedModel& model, const DetailLevel& level, const Mesh& surface,
                    std::span<const std::uint32_t> block_rows, std::span<const std::uint32_t> coefficient_offsets,
                    const std::pmr::vector<RowBlockMatrix>& matrices, std::pmr::memory_resource& memory,
                    std::pmr::memory_resource& heap);

  bool uses(std::uint32_t column) const { return used[column] != 0; }

  std::uint32_t vertices, blocks;               // the first ones in baked order
  std::pmr::vector<std::uint8_t> used;          // by column of the basis: whether its coefficient does not count as 0
  CsrTable<RegionInputs> block_regions;         // by row block, of those columns; of channels, too
  std::pmr::vector<std::uint32_t> outputs;      // by region: its first so many have all that the surface's blocks use
  std::pmr::vector<std::uint32_t> all_outputs;  // the same with the blocks of channels
  VertexNormals normals;                        // of the level's polygons, for its vertices in baked order
  VertexTangents tangents;
};

// The levels of a face; empty for a face without.
struct DetailLayout {
  explicit DetailLayout(std::pmr::memory_resource& memory) : levels(&memory), points(&memory) {}
  // Lays out the levels of a model, whose other parts have been laid out. `heap`: of temporaries.
  void add_levels(const PackedModel& model, std::span<const std::uint32_t> baked_index,
                  std::span<const std::uint32_t> coefficient_offsets, const std::pmr::vector<RowBlockMatrix>& matrices,
                  std::pmr::memory_resource& memory, std::pmr::memory_resource& heap);
  // `surface`: vertices of level 0, the whole.
  std::uint32_t vertices_at(std::size_t level, std::uint32_t surface) const {
    return level == 0 ? surface : levels[level - 1].vertices;
  }

  std::pmr::vector<DetailLevelLayout> levels;  // level 1, 2, ...
  std::pmr::vector<DetailPoint> points;        // of the vertices that the last level does not have, in baked order
};

// A level of detail as a batch chooses it: between a level and the next one.
struct DetailChoice {
  // lod: 0 or more; beyond the last level: that one.
  DetailChoice(const DetailLayout& layout, float lod);

  const DetailLevelLayout* level = nullptr;  // null: the whole
  const DetailLevelLayout* next = nullptr;   // towards which vertices slide; null: none
  std::size_t number = 0;                    // of `level`
  float share = 0;                           // of the way to `next`, below 1
};

// Moves vertices to where they lie at a level: those of the level that the next one does not have slide, and with `all`
// those that the level does not have are put on its surface. `rows`: positions in baked order, of which those of the
// level have been evaluated; only first..end - 1 are moved.
void slide_vertices(const DetailLayout& layout, const DetailChoice& choice, std::uint32_t first, std::uint32_t end,
                    bool all, float* rows);

}  // namespace fb::runtime
