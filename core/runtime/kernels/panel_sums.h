// The one hot loop of the runtime.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fb {

// A column of a panel whose input is not 0: its place among the panel's columns, and that input, in -32512..32512.
struct ActiveColumn {
  std::uint32_t place;
  std::int32_t input;
};

// sums[r] = sum over the active columns of input * digit r of the column, for r < rows: 16, 32, 48 or 64. Columns lie
// one after the other in `digits`, `rows` numbers each. The caller sees to it that no sum leaves 32 bits, so the result
// is exact and does not depend on the order.
void panel_sums(const std::int8_t* digits, std::size_t rows, std::span<const ActiveColumn> active, std::int32_t* sums);

}  // namespace fb
