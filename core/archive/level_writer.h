// Writes the section that level_reader.h reads.
#pragma once

#include "archive/container/byte_writer.h"
#include "model/packed_model.h"

namespace fb::archive {

// Of a model with levels.
ByteWriter write_levels(const PackedModel& model);

}  // namespace fb::archive
