// What a piece of a basis column is coded as: the writer codes it, and who rounds counts what it would cost.
#pragma once

#include <bit>
#include <cstdint>
#include <cstdlib>

#include "archive/coding/basis_coding.h"

namespace fb::archive {

inline std::uint32_t class_of(AxisNumbers residuals) {
  return bits_of(magnitudes(residuals));
}

// The numbers of a vertex once its piece has these values.
inline AxisNumbers numbers_of(const ColumnState& state, const BasisPiece& piece, const std::int16_t* values) {
  AxisNumbers numbers = state.numbers(piece.slot);
  for (std::uint32_t i = 0; i < piece.count; ++i) numbers[piece.axis + i] = values[i];
  return numbers;
}

// The numbers of a piece minus what is predicted for them; 0 on axes that it does not have.
inline AxisNumbers residuals_of(const ColumnState& state, const BasisPiece& piece, AxisNumbers numbers) {
  const AxisNumbers predicted = state.predicted(piece);
  AxisNumbers residuals{};
  for (std::uint32_t axis = piece.axis; axis < std::uint32_t(piece.axis) + piece.count; ++axis)
    residuals[axis] = numbers[axis] - predicted[axis];
  return residuals;
}

// Gives `out` (see SymbolWriter) the symbols and bits of a piece with these residuals. FORMAT.md describes them.
template <class Out>
void code_piece(Out& out, const ColumnState& state, const BasisPiece& piece, AxisNumbers residuals) {
  const std::uint32_t bits = class_of(residuals), context = first_context(state.context_key(piece));
  if (bits < 2) {
    std::uint32_t symbol = 0;
    for (std::size_t axis = 3; axis-- > 0;) symbol = 3 * symbol + (residuals[axis] < 0 ? 2 : residuals[axis]);
    return out.symbol(context, symbol);
  }
  out.symbol(context, class_symbols + bits);
  const int reach = (1 << bits) - 1;
  const std::uint32_t finer = bits > coded_bits ? bits - coded_bits : 0;
  bool reached = false;
  for (std::uint32_t i = 0; i < piece.count; ++i) {
    const std::size_t axis = piece.axis + i;
    const auto code = static_cast<std::uint32_t>(residuals[axis] + reach);
    out.symbol(ColumnState::residual_context(bits, state.level(piece, axis), i + 1 == piece.count, reached),
               code >> finer);
    if (finer > 0) out.bits(finer, code & ((1u << finer) - 1));
    reached = reached || std::abs(residuals[axis]) > reach / 2;
  }
}

}  // namespace fb::archive
