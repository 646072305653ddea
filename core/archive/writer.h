#pragma once

#include <cstddef>
#include <vector>

#include "archive/proof.h"
#include "model/face_model.h"

namespace fb {

// The bytes of the .fbk of a model: the same model and proof give the same bytes. Weights and basis are rounded to 16
// bits as FORMAT.md states, everything else is kept exactly, so measure what read_archive gives back, not `model`.
// Fails with bad_data or not_finite if the model fails its check or the proof does not fit it, with limit if a count is
// beyond the format.
std::vector<std::byte> write_archive(const FaceModel& model, const Proof& proof);

}  // namespace fb
