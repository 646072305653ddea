// Reads the sections of network weights and of the basis. Input is untrusted: every function fails with `corrupt`,
// `unsupported` or `limit` and names section and byte offset.
#pragma once

#include <cstdint>

#include "archive/container/byte_reader.h"
#include "model/packed_model.h"

namespace fb::archive {

inline constexpr std::uint8_t segment_16_bit_flag = 1, segment_new_scale_flag = 2;

// Fills the weights of all layers. Section "network" has been read.
void read_weights(ByteReader& in, PackedModel& model);
// Fills columns, order and the row blocks except their values.
void read_basis(ByteReader& in, std::uint32_t vertices, PackedModel& model);
// Fills the values of the row blocks. Section "basis" and the polygons have been read; points are not needed.
void read_basis_values(ByteReader& in, std::uint32_t vertices, PackedModel& model);

}  // namespace fb::archive
