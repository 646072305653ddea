// What the sections of an .fbk hold, one function each. All treat their input as untrusted and fail with `corrupt`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "archive/container/byte_reader.h"
#include "archive/container/layout.h"
#include "archive/proof.h"
#include "model/packed_model.h"

namespace fb::archive {

struct Definition {
  RigSchema schema;
  std::uint32_t vertices = 0;
};

Definition read_definition(ByteReader& in);
// The rest points in vertex order, and the triangles they came with.
struct RestPoints {
  std::vector<float> points;             // 3 x vertices
  std::vector<std::uint32_t> triangles;  // 3 vertices of each; none where points are as stored
};
RestPoints read_geometry(ByteReader& in, std::uint32_t vertices);
// What follows the section's numbers: Draco data of that many triangles, its positions times `step`, unless that is 0.
RestPoints read_draco(ByteReader& in, PointOrder order, std::uint32_t vertices, std::uint64_t triangles, float step);

// Fills polygon_sizes and polygon_corners; corners are below `vertices`. Polygons may be told along triangles.
void read_polygons(ByteReader& in, std::uint32_t vertices, const std::vector<std::uint32_t>& triangles, Mesh& mesh);
// The parts of that. The number of corners is given back; steps end the section.
std::uint32_t read_polygon_sizes(ByteReader& in, Mesh& mesh);
// Reads corner_steps, to the end of the section, of polygons of these sizes; corners are below `limit`. `what` says of
// a corner that is not.
std::vector<std::uint32_t> read_corner_steps(ByteReader& in, const std::vector<std::uint32_t>& sizes,
                                             std::uint32_t corners, std::uint32_t limit, const char* what);
void read_polygon_steps(ByteReader& in, std::uint32_t vertices, std::uint32_t corners, Mesh& mesh);
// Fills uvs and uv_corners. Polygons have been read.
void read_uvs(ByteReader& in, std::uint32_t vertices, Mesh& mesh);
// Fills features, direct and regions, but for weights; `tail` reads what versions before 1.0 had after each layer,
// whose biases and scales were not in planes either.
using LayerTail = void (*)(ByteReader& in, PackedLayer& layer);
void read_network(ByteReader& in, PackedModel& model, LayerTail tail = nullptr);
void read_weights(ByteReader& in, PackedModel& model);
// Fills columns, order and groups, whose rows are those of `vertices`, but for values.
void read_basis(ByteReader& in, std::uint32_t vertices, PackedModel& model);
// The values of the basis. Everything else of it and the rest mesh, but for its points, have been read.
void read_basis_values(ByteReader& in, std::uint32_t vertices, PackedModel& model);
Proof read_proof(ByteReader& in, std::size_t controls, std::uint32_t vertices);
std::string read_text(ByteReader& in);

}  // namespace fb::archive
