// The contents of each section, unpacked; the counterpart of section_reader.h. Models given here have passed check().
#pragma once

#include "archive/byte_writer.h"
#include "archive/proof.h"
#include "model/face_model.h"

namespace fb {

ByteWriter write_definition(const FaceModel& model);
ByteWriter write_polygons(const Mesh& mesh);
// Fails with `internal` if no encoding gives the points back bit for bit.
ByteWriter write_geometry(const Mesh& mesh);
ByteWriter write_network(const Network& network);
ByteWriter write_basis(const Basis& basis);
ByteWriter write_proof(const Proof& proof, const FaceModel& model);

}  // namespace fb
