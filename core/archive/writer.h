#pragma once

#include <cstddef>
#include <vector>

#include "archive/proof.h"
#include "model/packed_model.h"

namespace fb::archive {

// The bytes of the .fbk of a model: the same model, proof and text give the same bytes, and reading them gives the very
// model back. Fails with bad_data or not_finite if the model fails its check or the proof does not fit it, with limit
// if a count is beyond the format.
std::vector<std::byte> write_archive(const PackedModel& model, const Proof& proof, const ArchiveText& text = {});

}  // namespace fb::archive
