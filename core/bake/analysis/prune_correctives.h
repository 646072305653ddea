#pragma once

#include <span>

#include "bake/analysis/rig_analysis.h"
#include "model/rig_schema.h"

namespace fb::bake {

// Keeps in the base those terms of correctives that lower the error most for the bytes a pose reads of them, until an
// average pose reads `bytes` (3 a vertex of every active shape); what a dropped term did is added to residual_motion,
// where networks find it. Its features stay. `controls`: poses that stand for those to come, poses x controls;
// diagonal: of the rest mesh. Returns the number of correctives dropped.
std::size_t prune_correctives(RigAnalysis& analysis, const RigSchema& schema, std::span<const float> controls,
                              double diagonal, double bytes);

}  // namespace fb::bake
