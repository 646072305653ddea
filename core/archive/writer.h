// Writes a packed model as an .fbk archive. FORMAT.md beside this file is the normative description.
#pragma once

#include <cstddef>
#include <vector>

#include "archive/proof.h"
#include "model/packed_model.h"

namespace fb::archive {

// Returns the bytes of the archive. Deterministic: the same model, proof and text give the same bytes, and reading them
// gives back the same model. Fails with bad_data or not_finite if the model fails its check or the proof does not fit
// it, with limit if a count exceeds the format.
std::vector<std::byte> write_archive(const PackedModel& model, const Proof& proof, const ArchiveText& text = {});

}  // namespace fb::archive
