// Writes the sections of section_reader.h: each function returns the uncompressed contents. Models have passed check().
#pragma once

#include <string>

#include "archive/container/byte_writer.h"
#include "archive/proof.h"
#include "model/packed_model.h"

namespace fb::archive {

// Fails with `limit` for more than max_vertices vertices.
ByteWriter write_definition(const PackedModel& model);
ByteWriter write_network(const PackedModel& model);
// Fails with bad_data if the proof does not fit the model.
ByteWriter write_proof(const Proof& proof, const PackedModel& model);
// Fails with bad_data, naming `what`, if the text holds a zero byte.
ByteWriter write_text(const std::string& text, const char* what);

}  // namespace fb::archive
