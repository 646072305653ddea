// The symbols of a coding unit: the writer codes them, and rate-distortion quantisation adds up their cost.
#pragma once

#include <bit>
#include <cstdint>
#include <cstdlib>

#include "archive/coding/contexts.h"

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

// Codes a unit with these residuals. `Sink`: has symbol(context, value) and bits(count, value), as RansWriter has.
template <class Sink>
void write_unit(Sink& out, const ColumnHistory& history, const CodingUnit& unit, AxisVector residuals) {
  const std::uint32_t unit_class = class_of(residuals), context = class_context(history.condition(unit));
  if (unit_class < 2) {
    std::uint32_t symbol = 0;
    for (std::size_t axis = 3; axis-- > 0;) symbol = 3 * symbol + (residuals[axis] < 0 ? 2 : residuals[axis]);
    return out.symbol(context, symbol);
  }
  out.symbol(context, class_symbol_base + unit_class);
  const int offset = (1 << unit_class) - 1;
  const std::uint32_t raw_bits = unit_class > max_coded_bits ? unit_class - max_coded_bits : 0;
  bool class_reached = false;
  for (std::uint32_t i = 0; i < unit.count; ++i) {
    const std::size_t axis = unit.axis + i;
    const auto code = static_cast<std::uint32_t>(residuals[axis] + offset);
    out.symbol(residual_context(unit_class, history.activity(unit, axis), i + 1 == unit.count, class_reached),
               code >> raw_bits);
    if (raw_bits > 0) out.bits(raw_bits, code & ((1u << raw_bits) - 1));
    class_reached = class_reached || std::abs(residuals[axis]) > offset / 2;
  }
}

}  // namespace fb::archive
