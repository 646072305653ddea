// How the numbers of a basis are predicted and in which contexts they are coded: what reader and writer of the section
// "basis-values" share. FORMAT.md describes it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "archive/coding/basis_pieces.h"
#include "archive/coding/symbol_reader.h"

namespace fb::archive {

// The first symbol of a piece: below `small_pieces`, all residuals, each of -1..1; otherwise its class, the bits of its
// largest residual, plus `class_symbols`.
inline constexpr std::uint32_t small_pieces = 27, class_symbols = 25;
inline constexpr std::array<int, 3> small_residuals = {0, 1, -1};  // of the digits, to base 3, of a small piece
inline constexpr std::uint32_t most_class = 17;  // of a wide number that is predicted as wrongly as can be
inline constexpr std::uint32_t coded_bits = 6;   // of a residual's magnitude; what is finer is stored as bits

// Contexts: of choices of predictors, of first symbols, of residuals.
inline constexpr std::uint32_t choice_contexts = 2, class_levels = 42, residual_levels = 7;
inline constexpr std::uint32_t first_contexts = 2 * class_levels + 1;
inline constexpr std::uint32_t basis_contexts = choice_contexts + first_contexts + 8 * 3 * residual_levels;

// Only a piece of more than one prediction has its choice coded.
inline std::uint32_t choice_context(const BasisPiece& piece) {
  return piece.surroundings == closes_parallelogram ? 0 : 1;
}

// One for each axis; the fourth has no meaning. They are computed with, kept and fetched as one, because what was
// stored in parts is slow to fetch as a whole right afterwards.
using AxisNumbers = std::int32_t __attribute__((vector_size(16)));

inline AxisNumbers magnitudes(AxisNumbers numbers) {
  return numbers < 0 ? -numbers : numbers;
}
// As many bits as the largest magnitude has.
inline std::uint32_t bits_of(AxisNumbers magnitudes) {
  return static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint32_t>(magnitudes[0]) |
                                                   static_cast<std::uint32_t>(magnitudes[1]) |
                                                   static_cast<std::uint32_t>(magnitudes[2])));
}

// A context_key is what is known when the first symbol of a piece is coded: for each surroundings 32 times the sum of
// the classes of the neighbours coded last, plus the bits of the last but one's largest number.
inline constexpr std::uint32_t context_keys_each = 32 * (2 * most_class + 1), context_keys = 3 * context_keys_each;
constexpr std::uint32_t first_context(std::uint32_t context_key) {
  const std::uint32_t sum = context_key % context_keys_each / 32, magnitude = context_key % 32;
  const std::uint32_t level =
      sum == 0 ? magnitude > 0 : 1 + std::min(sum, 20u) + (magnitude > (sum + 1) / 2 + 2 ? 20 : 0);
  return choice_contexts + class_levels * (context_key / context_keys_each) + level;
}

// What is known of one column while it is coded: of all vertices, by slots, 0 where not coded yet.
class ColumnState {
 public:
  explicit ColumnState(std::size_t vertices) : coded_(vertices + 1) {}

  // The column's next place begins.
  void begin_place(bool wide) { largest_ = AxisNumbers{} + (wide ? largest_wide : largest_narrow); }
  AxisNumbers largest() const { return largest_; }  // magnitudes of numbers here

  // What the vertex of a piece is predicted to be.
  AxisNumbers predicted(const BasisPiece& piece) const {
    const auto& [one, other] = piece.predictors;
    return (numbers(one.left) + numbers(one.right) - numbers(one.across) + numbers(other.left) + numbers(other.right) -
            numbers(other.across) + 1) >>
           1;
  }
  AxisNumbers numbers(std::uint32_t slot) const { return coded_[slot].numbers; }

  // Of the neighbour coded last only the class is asked for, as its numbers are known so much later.
  std::uint32_t context_key(const BasisPiece& piece) const {
    const auto one = static_cast<std::uint32_t>(coded_[piece.last].trace[3]),
               other = static_cast<std::uint32_t>(coded_[piece.last_but_one].trace[3]);
    return context_keys_each * piece.surroundings + one / 32 * 32 + other;
  }
  // How large the residuals on this axis are at the neighbours coded last, in 0..residual_levels - 1.
  std::uint32_t level(const BasisPiece& piece, std::size_t axis) const {
    const auto sum =
        static_cast<std::uint32_t>(coded_[piece.last].trace[axis] + coded_[piece.last_but_one].trace[axis]);
    return std::min({sum, 2 + sum / 2, residual_levels - 1});
  }
  // In a piece of this class (2 or more), after whether a residual of as many bits was `reached` and for its last row.
  static std::uint32_t residual_context(std::uint32_t bits, std::uint32_t level, bool last, bool reached) {
    return choice_contexts + first_contexts + 3 * (residual_levels * (std::min(bits, 9u) - 2) + level) +
           (reached ? 1
            : last  ? 2
                    : 0);
  }

  // What a vertex is coded as, in a piece of this class.
  void set(std::uint32_t slot, AxisNumbers numbers, AxisNumbers residuals, std::uint32_t bits) {
    AxisNumbers trace = magnitudes(residuals);
    trace[3] = static_cast<std::int32_t>(32 * bits + bits_of(magnitudes(numbers)));
    coded_[slot] = {numbers, trace};
  }
  // Forgets what was coded of these pieces.
  void forget(const std::vector<BasisPiece>& pieces) {
    for (const BasisPiece& piece : pieces) coded_[piece.slot] = {};
  }

 private:
  struct Coded {
    AxisNumbers numbers{};
    AxisNumbers trace{};  // magnitudes of the residuals; 32 times the class, plus the bits of the largest number
  };

  std::vector<Coded> coded_;
  AxisNumbers largest_{};
};

// The columns of each stream: from number [stream] to before number [stream + 1].
std::array<std::size_t, symbol_streams + 1> columns_of_streams(const PackedModel& model,
                                                               const std::vector<std::vector<ColumnPlace>>& places);

}  // namespace fb::archive
