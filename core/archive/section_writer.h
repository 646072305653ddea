// The contents of each section, unpacked; the counterpart of section_reader.h. Models given here have passed check().
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "archive/container/byte_writer.h"
#include "archive/proof.h"
#include "model/packed_model.h"

namespace fb::archive {

ByteWriter write_definition(const PackedModel& model);
struct WrittenGeometry {
  ByteWriter section;
  std::vector<std::uint32_t> triangles;  // as a reader gets them, see RestPoints
};
// Fails with `internal` if no encoding gives the points back bit for bit.
WrittenGeometry write_geometry(const Mesh& mesh);
// `triangles`: those of the geometry.
ByteWriter write_polygons(const Mesh& mesh, const std::vector<std::uint32_t>& triangles);
// What each corner is away from the corner_before it, in zigzag form.
std::vector<std::uint32_t> corner_steps(const std::vector<std::uint32_t>& sizes,
                                        const std::vector<std::uint32_t>& corners);
ByteWriter write_uvs(const Mesh& mesh);
ByteWriter write_network(const PackedModel& model);
ByteWriter write_weights(const PackedModel& model);
ByteWriter write_basis(const PackedModel& model);
ByteWriter write_basis_values(const PackedModel& model);
ByteWriter write_proof(const Proof& proof, const PackedModel& model);
ByteWriter write_text(const std::string& text, const char* what);

}  // namespace fb::archive
