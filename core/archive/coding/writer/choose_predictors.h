// The writer's choice of predictors.
#pragma once

#include <vector>

#include "archive/coding/coding_units.h"

namespace fb::archive {

// The coding units of the model's row blocks in coding order, each with the predictor pair for which the residuals of
// all columns are estimated to take fewest bits.
CodingUnits choose_predictors(const PackedModel& model);

}  // namespace fb::archive
