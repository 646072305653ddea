// The frequency tables of weights and basis values, and the symbols of basis values: shared by reader and writer. See
// FORMAT.md.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "archive/coding/coding_units.h"

namespace fb::archive {

// Tables of section "weights": 0 to 2 by the layer's position in its region, for 8-bit weights. 16-bit weights use
// these plus 3 for the high and plus 6 for the low digit.
inline constexpr std::uint32_t weight_tables = 9, high_digit_tables = 3, low_digit_tables = 6;
constexpr std::uint32_t weight_table(std::size_t layer, std::size_t layers) {
  return layer + 1 == layers ? 2 : layer == 0 ? 0 : 1;
}

// The class of a coding unit is the number of bits of its largest residual. Class symbols below 27 also hold the
// residuals, each of -1..1; classes from 2 on are coded as the class plus 25.
inline constexpr std::uint32_t small_unit_symbols = 27, class_symbol_base = 25;
inline constexpr std::array<int, 3> small_residuals = {0, 1, -1};  // of the base-3 digits of a class symbol below 27
inline constexpr std::uint32_t max_class = 17;                     // of the worst prediction of a 16-bit value
inline constexpr std::uint32_t max_coded_bits = 6;  // of a residual's magnitude; lower bits are stored raw

// Tables of section "basis-values": of predictor pairs, of residuals, and of the class symbols of segments, each of
// which names one of the last kind.
inline constexpr std::uint32_t pair_table = 0, first_residual_table = 1, first_class_table = 1 + 8 * 3;
inline constexpr std::uint32_t max_class_tables = 64;

// The table of a residual in a unit of this class, 2 or more. `last`: of the unit's last row. `class_reached`: a
// residual before it in the unit has as many bits as the class.
constexpr std::uint32_t residual_table(std::uint32_t unit_class, bool last, bool class_reached) {
  // Branch-free: both are unpredictable.
  const std::uint32_t kind = std::uint32_t(class_reached) | std::uint32_t(last && !class_reached) << 1;
  return first_residual_table + 3 * (std::min(unit_class, 9u) - 2) + kind;
}

// The values or residuals of one vertex by axis, x, y and z; the fourth is unused. One SIMD vector, because loading as
// a vector what was just stored as scalars stalls the processor.
using AxisVector = std::int32_t __attribute__((vector_size(16)));

inline AxisVector magnitudes(AxisVector values) {
  return values < 0 ? -values : values;
}
// The number of bits of the largest magnitude.
inline std::uint32_t bit_width_of(AxisVector magnitudes) {
  return static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint32_t>(magnitudes[0]) |
                                                   static_cast<std::uint32_t>(magnitudes[1]) |
                                                   static_cast<std::uint32_t>(magnitudes[2])));
}

// The values of one column coded so far, from which predictions follow. Indexed by rank; all 0 where nothing is coded
// yet.
class ColumnHistory {
 public:
  explicit ColumnHistory(std::size_t vertices, std::pmr::memory_resource& memory = *std::pmr::get_default_resource())
      : values_(vertices + 1, &memory) {}

  // The rounded mean of the unit's two predictors.
  AxisVector predicted(const CodingUnit& unit) const {
    const auto& [a, b] = unit.predictors;
    return (values(a.left) + values(a.right) - values(a.across) + values(b.left) + values(b.right) - values(b.across) +
            1) >>
           1;
  }
  AxisVector values(std::uint32_t rank) const { return values_[rank]; }
  void set(std::uint32_t rank, AxisVector values) { values_[rank] = values; }
  // Clears the vertices of these units.
  void clear(std::span<const CodingUnit> units) {
    for (const CodingUnit& unit : units) values_[unit.rank] = AxisVector{};
  }

 private:
  std::pmr::vector<AxisVector> values_;
};

}  // namespace fb::archive
