// The contents of each section, unpacked; the counterpart of section_reader.h. Models given here have passed check().
#pragma once

#include <string>

#include "archive/byte_writer.h"
#include "archive/proof.h"
#include "model/packed_model.h"

namespace fb {

ByteWriter write_definition(const PackedModel& model);
ByteWriter write_polygons(const Mesh& mesh);
// Fails with `internal` if no encoding gives the points back bit for bit.
ByteWriter write_geometry(const Mesh& mesh);
ByteWriter write_network(const PackedModel& model);
ByteWriter write_weights(const PackedModel& model);
ByteWriter write_basis(const PackedModel& model);
ByteWriter write_basis_values(const PackedModel& model);
ByteWriter write_proof(const Proof& proof, const PackedModel& model);
ByteWriter write_text(const std::string& text, const char* what);

}  // namespace fb
