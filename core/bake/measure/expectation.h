#pragma once

#include <optional>

#include "bake/measure/evaluate.h"
#include "bake/measure/measured_face.h"

namespace fb::bake {

// Writes to each frame of a report what the face itself expects of it: FrameErrors::expected and outside. Returns how
// well that agrees with what was measured. Nothing without Detail::quality, or where the model has no expected errors.
std::optional<Expectation> compare_expected_errors(MeasuredFace& posed, EvalReport& report, const Source& source);

}  // namespace fb::bake
