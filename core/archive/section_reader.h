// What the sections of an .fbk hold, one function each. All treat their input as untrusted and fail with `corrupt`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "archive/byte_reader.h"
#include "archive/proof.h"
#include "model/packed_model.h"

namespace fb {

struct Definition {
  RigSchema schema;
  std::uint32_t vertices = 0;
};

Definition read_definition(ByteReader& in);
// Fills polygon_sizes and polygon_corners; corners are below `vertices`.
void read_polygons(ByteReader& in, std::uint32_t vertices, Mesh& mesh);
// The rest points in vertex order: 3 x vertices. `triangles` is how many the polygons fan into.
std::vector<float> read_geometry(ByteReader& in, std::uint32_t vertices, std::uint64_t triangles);
// Fills features, direct and regions, but for weights; `tail` reads what versions before 1.0 had after each layer.
using LayerTail = void (*)(ByteReader& in, PackedLayer& layer);
void read_network(ByteReader& in, PackedModel& model, LayerTail tail = nullptr);
void read_weights(ByteReader& in, PackedModel& model);
// Fills columns, order and groups, whose rows are those of `vertices`, but for values.
void read_basis(ByteReader& in, std::uint32_t vertices, PackedModel& model);
// The values of the basis. Everything else of it and the rest mesh, but for its points, have been read.
void read_basis_values(ByteReader& in, std::uint32_t vertices, PackedModel& model);
Proof read_proof(ByteReader& in, std::size_t controls, std::uint32_t vertices);
std::string read_text(ByteReader& in);

}  // namespace fb
