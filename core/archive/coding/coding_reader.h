// Reads the sections of network weights and of the basis. Input is untrusted: every function fails with `corrupt`,
// `unsupported` or `limit` and names section and byte offset.
#pragma once

#include <cstdint>
#include <memory_resource>
#include <vector>

#include "archive/container/byte_reader.h"
#include "base/parallel.h"
#include "model/packed_model.h"

namespace fb::archive {

// Flags of a segment, and the first bit of the number of its class table.
inline constexpr std::uint8_t segment_16_bit_flag = 1, segment_new_scale_flag = 2, segment_table_shift = 2;

// The class table of each segment, in the order of column_segments.
using SegmentTables = std::pmr::vector<std::uint8_t>;

// Fills the weights of all layers. Section "network" has been read.
void read_weights(ByteReader& in, PackedModel& model);
// Fills columns, order and the row blocks except their values.
SegmentTables read_basis(ByteReader& in, std::uint32_t vertices, PackedModel& model);
// Fills the values of the row blocks, whose parts are decoded in parallel. `tables`: from section "basis". The polygons
// have been read; points are not needed. Fails with `invalid_argument`, too, if a host does not run each part once.
void read_basis_values(ByteReader& in, std::uint32_t vertices, const SegmentTables& tables, const Parallel& parallel,
                       PackedModel& model);

}  // namespace fb::archive
