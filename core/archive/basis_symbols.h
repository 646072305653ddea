// What a piece of a basis column is coded as: the writer codes it, and who rounds counts what it would cost.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "archive/basis_coding.h"

namespace fb {

// Of axes that a piece does not have, numbers and residuals are 0.
inline std::uint32_t class_of(const AxisNumbers& residuals) {
  std::uint32_t digits = 0;  // as many bits as the largest magnitude has
  for (const int residual : residuals) digits |= static_cast<std::uint32_t>(std::abs(residual));
  return static_cast<std::uint32_t>(std::bit_width(digits));
}

// The numbers of a piece minus what is foretold for them.
inline AxisNumbers residuals_of(const ColumnState& state, const BasisPiece& piece, const AxisNumbers& numbers) {
  AxisNumbers residuals{};
  for (std::size_t axis = piece.axis; axis < std::size_t(piece.axis) + piece.count; ++axis)
    residuals[axis] = numbers[axis] - state.foretold(piece, axis);
  return residuals;
}

// Tells `state` what a piece was coded as.
inline void keep_piece(ColumnState& state, const BasisPiece& piece, const AxisNumbers& numbers,
                       const AxisNumbers& residuals) {
  std::uint32_t digits = 0;
  for (std::size_t axis = piece.axis; axis < std::size_t(piece.axis) + piece.count; ++axis) {
    digits |= static_cast<std::uint32_t>(std::abs(numbers[axis]));
    state.set(piece.vertex, axis, numbers[axis], residuals[axis]);
  }
  state.done(piece.vertex, class_of(residuals), digits);
}

// Gives `out` (see SymbolWriter) the symbols and bits of a piece with these residuals. FORMAT.md describes them.
template <class Out>
void code_piece(Out& out, const ColumnState& state, const BasisPiece& piece, const AxisNumbers& residuals) {
  const std::uint32_t bits = class_of(residuals);
  out.symbol(class_lane, state.class_context(piece), bits);
  if (bits == 0) return;
  const int reach = (1 << bits) - 1;
  const std::uint32_t finer = bits > coded_bits ? bits - coded_bits : 0;
  bool reached = false;
  for (std::uint32_t i = 0; i < piece.count; ++i) {
    const std::size_t axis = piece.axis + i;
    const auto code = static_cast<std::uint32_t>(residuals[axis] + reach);
    out.symbol(i, ColumnState::residual_context(bits, state.level(piece, axis), i + 1 == piece.count, reached),
               code >> finer);
    if (finer > 0) out.bits(i, finer, code & ((1u << finer) - 1));
    reached = reached || std::abs(residuals[axis]) > reach / 2;
  }
}

}  // namespace fb
