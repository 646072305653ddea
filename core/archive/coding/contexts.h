// The contexts in which weights and basis values are coded, and the symbols of basis values: shared by reader and
// writer. See FORMAT.md.
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

// Contexts of section "weights": 0 to 2 by the layer's position in its region, for 8-bit weights. 16-bit weights use
// these plus 3 for the high and plus 6 for the low digit.
inline constexpr std::uint32_t weight_contexts = 9, high_digit_contexts = 3, low_digit_contexts = 6;
constexpr std::uint32_t weight_context(std::size_t layer, std::size_t layers) {
  return layer + 1 == layers ? 2 : layer == 0 ? 0 : 1;
}

// The class of a coding unit is the number of bits of its largest residual. Class symbols below 27 also hold the
// residuals, each of -1..1; classes from 2 on are coded as the class plus 25.
inline constexpr std::uint32_t small_unit_symbols = 27, class_symbol_base = 25;
inline constexpr std::array<int, 3> small_residuals = {0, 1, -1};  // of the base-3 digits of a class symbol below 27
inline constexpr std::uint32_t max_class = 17;                     // of the worst prediction of a 16-bit value
inline constexpr std::uint32_t max_coded_bits = 6;  // of a residual's magnitude; lower bits are stored raw

// Contexts of section "basis-values": of predictor pairs, of class symbols, of residuals.
inline constexpr std::uint32_t pair_contexts = 2, class_levels = 42, activity_levels = 7;
inline constexpr std::uint32_t class_contexts = 2 * class_levels + 1;
inline constexpr std::uint32_t basis_contexts = pair_contexts + class_contexts + 8 * 3 * activity_levels;

// Predictor pairs are coded only for units with more than one candidate.
inline std::uint32_t pair_context(const CodingUnit& unit) {
  return unit.neighbourhood == Neighbourhood::parallelogram ? 0 : 1;
}

// The values or residuals of one vertex by axis, x, y and z; lane 3 is unused. One SIMD vector, because loading as a
// vector what was just stored as scalars stalls the processor.
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

// A condition is what the class symbol's context depends on, as one number: neighbourhood x (sum of the classes of the
// two neighbours coded last) x (bits of the largest value of the last but one), the last two as 32 * sum + bits.
inline constexpr std::uint32_t conditions_per_neighbourhood = 32 * (2 * max_class + 1);
inline constexpr std::uint32_t condition_count = 3 * conditions_per_neighbourhood;
constexpr std::uint32_t class_context(std::uint32_t condition) {
  const std::uint32_t sum = condition % conditions_per_neighbourhood / 32, bits = condition % 32;
  const std::uint32_t level = sum == 0 ? bits > 0 : 1 + std::min(sum, 20u) + (bits > (sum + 1) / 2 + 2 ? 20 : 0);
  return pair_contexts + class_levels * (condition / conditions_per_neighbourhood) + level;
}

// The context of a residual in a unit of this class, 2 or more. `activity`: see ColumnHistory. `last`: of the unit's
// last row. `class_reached`: a residual before it in the unit has as many bits as the class.
constexpr std::uint32_t residual_context(std::uint32_t unit_class, std::uint32_t activity, bool last,
                                         bool class_reached) {
  return pair_contexts + class_contexts + 3 * (activity_levels * (std::min(unit_class, 9u) - 2) + activity) +
         (class_reached ? 1
          : last        ? 2
                        : 0);
}

// The values and residuals of one column coded so far, from which predictions and contexts follow. Indexed by rank; all
// 0 where nothing is coded yet.
class ColumnHistory {
 public:
  explicit ColumnHistory(std::size_t vertices, std::pmr::memory_resource& memory = *std::pmr::get_default_resource())
      : vertices_(vertices + 1, &memory) {}

  // The next segment of the column begins; `wide`: its values have 16 bits.
  void begin_segment(bool wide) { max_magnitude_ = AxisVector{} + (wide ? largest_wide : largest_narrow); }
  AxisVector max_magnitude() const { return max_magnitude_; }  // of the segment's values

  // The rounded mean of the unit's two predictors.
  AxisVector predicted(const CodingUnit& unit) const {
    const auto& [a, b] = unit.predictors;
    return (values(a.left) + values(a.right) - values(a.across) + values(b.left) + values(b.right) - values(b.across) +
            1) >>
           1;
  }
  AxisVector values(std::uint32_t rank) const { return vertices_[rank].values; }

  // See class_context. Uses only the class of the neighbour coded last: its values are known much later.
  std::uint32_t condition(const CodingUnit& unit) const {
    const auto last = static_cast<std::uint32_t>(vertices_[unit.last].statistics[3]),
               last_but_one = static_cast<std::uint32_t>(vertices_[unit.last_but_one].statistics[3]);
    return conditions_per_neighbourhood * static_cast<std::uint32_t>(unit.neighbourhood) + last / 32 * 32 +
           last_but_one;
  }
  // The activity on an axis, 0 to activity_levels - 1: how large the residuals of the two neighbours coded last are.
  std::uint32_t activity(const CodingUnit& unit, std::size_t axis) const {
    const auto sum = static_cast<std::uint32_t>(vertices_[unit.last].statistics[axis] +
                                                vertices_[unit.last_but_one].statistics[axis]);
    return std::min({sum, 2 + sum / 2, activity_levels - 1});
  }

  // Records the values and residuals of a vertex, coded in a unit of this class.
  void set(std::uint32_t rank, AxisVector values, AxisVector residuals, std::uint32_t unit_class) {
    AxisVector statistics = magnitudes(residuals);
    statistics[3] = static_cast<std::int32_t>(32 * unit_class + bit_width_of(magnitudes(values)));
    vertices_[rank] = {values, statistics};
  }
  // Clears the vertices of these units.
  void clear(std::span<const CodingUnit> units) {
    for (const CodingUnit& unit : units) vertices_[unit.rank] = {};
  }

 private:
  struct Vertex {
    AxisVector values{};
    AxisVector statistics{};  // magnitudes of the residuals; lane 3: 32 * class + bits of the largest value
  };

  std::pmr::vector<Vertex> vertices_;
  AxisVector max_magnitude_{};
};

}  // namespace fb::archive
