// Writes the sections of coding_reader.h: each function returns the uncompressed contents. Models have passed check().
#pragma once

#include "archive/container/byte_writer.h"
#include "model/packed_model.h"

namespace fb::archive {

ByteWriter write_weights(const PackedModel& model);
ByteWriter write_basis(const PackedModel& model);
ByteWriter write_basis_values(const PackedModel& model);

}  // namespace fb::archive
