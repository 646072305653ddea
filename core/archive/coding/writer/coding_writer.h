// Writes the sections of coding_reader.h: each function returns uncompressed contents. Models have passed check().
#pragma once

#include "archive/container/byte_writer.h"
#include "model/packed_model.h"

namespace fb::archive {

ByteWriter write_weights(const PackedModel& model);

struct BasisSections {
  ByteWriter columns, values;  // "basis" and "basis-values"
};
BasisSections write_basis(const PackedModel& model);

}  // namespace fb::archive
