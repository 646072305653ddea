// The symbols of coding units: the writer codes them, and rate-distortion quantisation adds up their cost.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "archive/coding/coding_symbols.h"

namespace fb::archive {

inline std::uint32_t class_of(AxisVector residuals) {
  return bit_width_of(magnitudes(residuals));
}

// The values of the unit's vertex once the unit has `values`, one per row.
inline AxisVector values_of_vertex(const ColumnHistory& history, const CodingUnit& unit, const std::int16_t* values) {
  AxisVector result = history.values(unit.rank);
  for (std::uint32_t i = 0; i < unit.count; ++i) result[unit.axis + i] = values[i];
  return result;
}

// Values minus prediction; 0 on axes that the unit does not have.
inline AxisVector residuals_of(const ColumnHistory& history, const CodingUnit& unit, AxisVector values) {
  const AxisVector predicted = history.predicted(unit);
  AxisVector residuals{};
  for (std::uint32_t axis = unit.axis; axis < std::uint32_t(unit.axis) + unit.count; ++axis)
    residuals[axis] = values[axis] - predicted[axis];
  return residuals;
}

// Codes the class symbol of a unit with these residuals, and returns its class. `class_table`: of its segment. `Sink`:
// has symbol(table, value) and bits(count, value), as RansWriter has.
template <class Sink>
std::uint32_t write_class(Sink& out, std::uint32_t class_table, AxisVector residuals) {
  const std::uint32_t unit_class = class_of(residuals);
  std::uint32_t symbol = class_symbol_base + unit_class;
  if (unit_class < 2) {
    symbol = 0;
    for (std::size_t axis = 3; axis-- > 0;) symbol = 3 * symbol + (residuals[axis] < 0 ? 2 : residuals[axis]);
  }
  out.symbol(first_class_table + class_table, symbol);
  return unit_class;
}

// Codes the residuals of a unit of this class, 2 or more.
template <class Sink>
void write_residuals(Sink& out, const CodingUnit& unit, std::uint32_t unit_class, AxisVector residuals) {
  const int offset = (1 << unit_class) - 1;
  const std::uint32_t raw_bits = unit_class > max_coded_bits ? unit_class - max_coded_bits : 0;
  bool class_reached = false;
  for (std::uint32_t i = 0; i < unit.count; ++i) {
    const std::size_t axis = unit.axis + i;
    const auto code = static_cast<std::uint32_t>(residuals[axis] + offset);
    out.symbol(residual_table(unit_class, i + 1 == unit.count, class_reached), code >> raw_bits);
    if (raw_bits > 0) out.bits(raw_bits, code & ((1u << raw_bits) - 1));
    class_reached = class_reached || std::abs(residuals[axis]) > offset / 2;
  }
}

// Both, for a sink that does not care for their order.
template <class Sink>
void write_unit(Sink& out, std::uint32_t class_table, const CodingUnit& unit, AxisVector residuals) {
  const std::uint32_t unit_class = write_class(out, class_table, residuals);
  if (unit_class >= 2) write_residuals(out, unit, unit_class, residuals);
}

// Calls begin(column, segment) for all segments in coding order, and after each function(history, unit, row block,
// index of the unit's first value in the block) for its units. The function records in `history` what the unit is coded
// as.
template <class Begin, class Function>
void for_each_unit(const PackedModel& model, const CodingUnits& units, Begin&& begin, Function&& function) {
  ColumnHistory history(model.rest.vertex_count());
  const ColumnSegments columns = column_segments(model);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (const ColumnSegment& segment : columns[c]) {
      begin(c, segment);
      for (const CodingUnit& unit : units[segment.block])
        function(history, unit, segment.block,
                 std::size_t(segment.index) * model.row_blocks[segment.block].row_count + unit.row);
    }
    for (const ColumnSegment& segment : columns[c]) history.clear(units[segment.block]);
  }
}

}  // namespace fb::archive
