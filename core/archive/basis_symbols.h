// What a piece of a basis column is coded as: the writer codes it, and who rounds counts what it would cost.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "archive/basis_coding.h"

namespace fb {

using PieceNumbers = std::array<int, 3>;  // of a piece's rows; those it does not have are 0

// Gives `out` (see SymbolWriter) the symbols and bits of a piece with these residuals. FORMAT.md describes them.
template <class Out>
void code_piece(Out& out, const ColumnState& state, const BasisPiece& piece, const PieceNumbers& residuals) {
  int most = 0;
  for (const int residual : residuals) most = std::max(most, std::abs(residual));
  const auto bits = static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint32_t>(most)));
  out.symbol(class_lane, state.class_context(piece), bits);
  if (bits == 0) return;
  const int reach = (1 << bits) - 1;
  const std::uint32_t finer = bits > coded_bits ? bits - coded_bits : 0;
  bool reached = false;
  for (std::uint32_t i = 0; i < piece.count; ++i) {
    const auto code = static_cast<std::uint32_t>(residuals[i] + reach);
    out.symbol(i, ColumnState::residual_context(bits, i + 1 == piece.count, reached), code >> finer);
    if (finer > 0) out.bits(i, finer, code & ((1u << finer) - 1));
    reached = reached || std::abs(residuals[i]) > reach / 2;
  }
}

// Tells `state` the numbers that a piece was coded with.
inline void keep_piece(ColumnState& state, const BasisPiece& piece, const PieceNumbers& numbers,
                       const PieceNumbers& residuals) {
  std::uint32_t magnitudes = 0, reaches = 0;  // as many bits as the largest has
  for (std::uint32_t i = 0; i < piece.count; ++i) {
    magnitudes |= static_cast<std::uint32_t>(std::abs(numbers[i]));
    reaches |= static_cast<std::uint32_t>(std::abs(residuals[i]));
    state.set(piece.vertex, piece.axis + i, numbers[i]);
  }
  state.done(piece.vertex, static_cast<std::uint32_t>(std::bit_width(reaches)), magnitudes);
}

}  // namespace fb
