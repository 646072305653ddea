// The writer's choice of class tables.
#pragma once

#include <cstdint>
#include <vector>

#include "archive/coding/coding_units.h"
#include "model/packed_model.h"

namespace fb::archive {

// The class table of each segment, in the order of column_segments, such that the class symbols take few bits: segments
// of like residuals share one. k-means with the bits of a segment's symbols as its distance from a table. `units`: of
// choose_predictors. There are at most max_class_tables tables, one for every 256 segments.
std::vector<std::uint8_t> choose_segment_tables(const PackedModel& model, const CodingUnits& units);

}  // namespace fb::archive
