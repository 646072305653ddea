// Reads the sections that are neither geometry nor entropy-coded. Input is untrusted: every function fails with
// `corrupt`, `unsupported` or `limit` and names section and byte offset.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "archive/container/byte_reader.h"
#include "archive/proof.h"
#include "model/packed_model.h"

namespace fb::archive {

inline constexpr std::uint32_t max_vertices = 0x10000000;  // keeps 3 x vertices and Draco's signed counts in range
inline constexpr std::uint8_t layer_skip_flag = 1, layer_16_bit_flag = 2;

struct Definition {
  RigSchema schema;
  std::uint32_t vertices = 0;
};

Definition read_definition(ByteReader& in);

// Fills features, direct and regions, except weights.
void read_network(ByteReader& in, PackedModel& model);

// What a proof has of each pose besides positions.
struct ProofSizes {
  std::size_t sockets = 0;
  std::size_t errors = 0;  // ExpectedErrors::count()
  std::size_t levels = 0;  // coarser ones
  bool driven = false;     // whether there are driven joints
};

// `vertices`: of the surface.
Proof read_proof(ByteReader& in, const RigSchema& schema, std::uint32_t vertices, const ProofSizes& sizes);
std::string read_text(ByteReader& in);

}  // namespace fb::archive
