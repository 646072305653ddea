// From which of its neighbours each vertex is predicted best.
#pragma once

#include <vector>

#include "archive/coding/basis_pieces.h"

namespace fb::archive {

// The pieces of a model's groups in the order they are coded (see basis_pieces), with those predictors by which the
// numbers of all columns take fewest bits, about.
std::vector<std::vector<BasisPiece>> best_pieces(const PackedModel& model);

}  // namespace fb::archive
