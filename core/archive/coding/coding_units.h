// The coding units of a basis, the order in which they are coded, and the predictors of their values: shared by reader
// and writer of section "basis-values". See FORMAT.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory_resource>
#include <span>
#include <vector>

#include "model/packed_model.h"

namespace fb::archive {

// Vertices are identified by rank: the order in which they are coded for the first time. The rank that equals the
// number of vertices means "no vertex"; its values are 0.
//
// Parallelogram prediction: value = left + right - across.
struct Predictor {
  std::uint32_t left = 0, right = 0, across = 0;  // ranks
};

// The rows of one vertex in one row block: one to three.
struct CodingUnit {
  std::uint32_t rank = 0;               // of the vertex
  std::uint32_t row = 0;                // the first row, counted within the block
  std::uint8_t axis = 0, count = 0;     // of the first row; number of rows
  std::uint8_t predictor_count = 1;     // candidates
  std::uint8_t predictor_pair = 0;      // the pair_index of the two candidates used
  std::array<Predictor, 2> predictors;  // the two used; the prediction is their mean
};

// Index of the pair of candidates i <= j: (0, 0), (0, 1), (1, 1), (0, 2), ...
constexpr std::uint32_t pair_index(std::uint32_t i, std::uint32_t j) {
  return j * (j + 1) / 2 + i;
}

// Sets the unit's predictors to a pair of the candidates.
void set_predictors(CodingUnit& unit, std::span<const Predictor> candidates, std::uint32_t pair);
// Calls set_predictors for a unit whose other members are set.
using SelectPredictors = std::function<void(CodingUnit& unit, std::span<const Predictor> candidates)>;

// The units of every row block in coding order.
using CodingUnits = std::pmr::vector<std::pmr::vector<CodingUnit>>;
// Calls `select` for each. Polygons (corners below `vertices`), order and the rows of the blocks have been checked. The
// mesh's points are not used. `memory`: of the result and of temporaries.
CodingUnits coding_units(const Mesh& mesh, std::uint32_t vertices, const std::vector<std::uint32_t>& order,
                         const std::vector<PackedRowBlock>& blocks, const SelectPredictors& select,
                         std::pmr::memory_resource& memory = *std::pmr::get_default_resource());

// A segment: the part of a column that lies in one row block.
struct ColumnSegment {
  std::uint32_t block = 0, index = 0;  // the row block, and the column's index in it
};

// The segments of every column, by ascending row block: the order in which they are coded.
using ColumnSegments = std::pmr::vector<std::pmr::vector<ColumnSegment>>;
ColumnSegments column_segments(const PackedModel& model,
                               std::pmr::memory_resource& memory = *std::pmr::get_default_resource());

// The parts of section "basis-values" can be decoded independently of each other.
inline constexpr std::size_t basis_parts = 4;
// The first column of each part, and the number of columns. Columns are split so that parts hold about as many values
// each.
std::array<std::size_t, basis_parts + 1> first_columns_of_parts(
    const PackedModel& model, const ColumnSegments& segments,
    std::pmr::memory_resource& memory = *std::pmr::get_default_resource());

}  // namespace fb::archive
