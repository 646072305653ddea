// In which order the numbers of a basis are coded, and from which they may be predicted: what reader and writer of the
// section "basis-values" share. FORMAT.md describes it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "model/packed_model.h"

namespace fb::archive {

// A number is predicted to be left + right - across. These are slots: the turns in which vertices were coded first, or
// as many as there are vertices where there is none, whose numbers are 0.
struct Predictor {
  std::uint32_t left = 0, right = 0, across = 0;
};

// The rows of one vertex in one row group.
struct BasisPiece {
  std::uint32_t slot = 0;                        // of the vertex
  std::uint32_t row = 0;                         // the first, counted within the group
  std::uint8_t axis = 0, count = 0;              // of the first row; rows: 1 to 3
  std::uint8_t surroundings = 0;                 // of the vertex, see below
  std::uint8_t predictor_count = 1, choice = 0;  // predictors there were, and which two were taken: pair_number of them
  std::uint32_t last = 0, last_but_one = 0;      // slots of the neighbours coded so; both the same if there is one
  std::array<Predictor, 2> predictors;           // predicted is the mean of these two
};

// A parallelogram of coded vertices ends at this one; others are coded beside it; none are.
enum : std::uint8_t { closes_parallelogram = 0, has_neighbours = 1, stands_alone = 2 };

// The pairs of predictors, i <= j, are numbered (0, 0), (0, 1), (1, 1), (0, 2), ...
constexpr std::uint32_t pair_number(std::uint32_t i, std::uint32_t j) {
  return j * (j + 1) / 2 + i;
}

// Sets the predictors of a piece to the pair of this number, of predictors that there are.
void choose_pair(BasisPiece& piece, std::span<const Predictor> predictors, std::uint32_t choice);
// What calls choose_pair for a piece, whose other members are set.
using ChoosePredictors = std::function<void(BasisPiece& piece, std::span<const Predictor> predictors)>;

// The pieces of every group in the order they are coded, for each of which `choose` is called. The polygons, whose
// corners are below `vertices`, the order and the rows of the groups have been checked; points are not looked at.
std::vector<std::vector<BasisPiece>> basis_pieces(const Mesh& mesh, std::uint32_t vertices,
                                                  const std::vector<std::uint32_t>& order,
                                                  const std::vector<PackedRowBlock>& groups,
                                                  const ChoosePredictors& choose);

// A column in a group.
struct ColumnPlace {
  std::uint32_t group = 0, index = 0;
};

// Where each column lies, by ascending groups: the order in which they are coded.
std::vector<std::vector<ColumnPlace>> column_places(const PackedModel& model);

}  // namespace fb::archive
