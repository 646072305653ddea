#pragma once

#include <span>

#include "export/glb_file.h"
#include "model/packed_model.h"
#include "runtime/evaluator.h"

namespace fb::tool {
using namespace runtime;

// A clip (frames x controls) as morph targets over the rest mesh: the frames themselves, or, where there are more of
// them than coefficients, the columns of the basis weighted by the coefficients. Both give the evaluator's positions,
// to its rounding of coefficients; between frames the one blends positions, the other coefficients, which is the same.
MorphAnimation animate(const PackedModel& model, const Evaluator& evaluator, std::span<const float> controls,
                       double fps, const Parallel& parallel);

// frames x 3 x vertices positions of a clip.
std::vector<float> evaluate_frames(const Evaluator& evaluator, std::span<const float> controls,
                                   const Parallel& parallel);

}  // namespace fb::tool
