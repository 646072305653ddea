// How the numbers of a basis are predicted and in which contexts they are coded: what reader and writer of the section
// "basis values" share. FORMAT.md describes it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "model/packed_model.h"

namespace fb {

// The rows of one vertex in one row group, and the vertices coded before by which they are foretold. Where there is no
// such vertex stands the number of vertices, whose numbers are 0 in ColumnState.
struct BasisPiece {
  std::uint32_t vertex = 0;
  std::uint32_t row = 0;             // the first, counted within the group
  std::uint8_t axis = 0, count = 0;  // of the first row; rows: 1 to 3
  // A number is foretold to be left + right - across: of a parallelogram whose fourth corner it is. Where `halved`,
  // across is 0 and half of that, rounded up: the mean of the neighbours coded last and last but one, or the only one.
  std::uint8_t halved = 1;
  std::uint32_t left = 0, right = 0, across = 0;
  std::uint32_t last = 0, last_but_one = 0;  // the neighbours coded so; both the same if there is one
};

// The pieces of every group in the order they are coded. The polygons, whose corners are below
// `vertices`, the order and the rows of the groups have been checked; points are not looked at.
std::vector<std::vector<BasisPiece>> basis_pieces(const Mesh& mesh, std::uint32_t vertices,
                                                  const std::vector<std::uint32_t>& order,
                                                  const std::vector<PackedRowGroup>& groups);

// Contexts: of classes (the bits of the largest residual of a piece), then of residuals.
inline constexpr std::uint32_t class_contexts = 52, residual_levels = 7;
inline constexpr std::uint32_t basis_contexts = class_contexts + 9 * 3 * residual_levels;
inline constexpr std::uint32_t coded_bits = 6;  // of a residual's magnitude; what is finer is stored as bits

inline constexpr std::size_t class_lane = 3;  // residuals are coded in lane 0, 1, 2

using AxisNumbers = std::array<int, 3>;  // one for each axis

// What is known of one column while it is coded: of all vertices, 0 where not coded yet.
class ColumnState {
 public:
  explicit ColumnState(std::size_t vertices) : seen_(vertices + 1), coded_(vertices + 1), nobody_(vertices) {
    for (std::uint32_t sum = 0; sum <= 2 * 16; ++sum)
      for (std::uint32_t magnitude = 0; magnitude < magnitudes; ++magnitude)
        contexts_[magnitudes * sum + magnitude] = static_cast<std::uint8_t>(
            sum == 0 ? magnitude > 0 : 1 + std::min(sum, 20u) + (magnitude > (sum + 1) / 2 + 2 ? 20 : 0));
  }

  // The column's next place begins.
  void begin_place(bool wide) {
    largest_ = wide ? largest_wide : largest_narrow;
    previous_ = 0;
  }
  int largest() const { return largest_; }                                         // magnitude of a number here
  std::uint32_t most_class() const { return largest_ > largest_narrow ? 16 : 8; }  // here

  // What the piece's vertex is foretold to be on this axis, in -largest()..largest().
  int foretold(const BasisPiece& piece, std::size_t axis) const {
    const int sum =
        seen_[piece.left].numbers[axis] + seen_[piece.right].numbers[axis] - seen_[piece.across].numbers[axis];
    return std::clamp((sum + piece.halved) >> piece.halved, -largest_, largest_);
  }

  // Of the neighbour coded last only the class is asked for, as its numbers are known so much later.
  std::uint32_t class_context(const BasisPiece& piece) const {
    if (piece.last == nobody_) return 42 + std::min<std::uint32_t>(previous_, 9);
    const std::uint32_t second = coded_[piece.last_but_one];
    return contexts_[magnitudes * (coded_[piece.last] % 256u + second % 256) + second / 256];
  }
  // How large the residuals on this axis are at the neighbours coded last, in 0..residual_levels - 1.
  std::uint32_t level(const BasisPiece& piece, std::size_t axis) const {
    const std::uint32_t sum = seen_[piece.last].residuals[axis] + seen_[piece.last_but_one].residuals[axis];
    return std::min({sum, 2 + sum / 2, residual_levels - 1});
  }
  static std::uint32_t residual_context(std::uint32_t bits, std::uint32_t level, bool last, bool reached) {
    return class_contexts + 3 * (residual_levels * (std::min(bits, 9u) - 1) + level) + (reached ? 1 : last ? 2 : 0);
  }

  // What an axis of a vertex is coded as.
  void set(std::uint32_t vertex, std::size_t axis, int number, int residual) {
    seen_[vertex].numbers[axis] = static_cast<std::int16_t>(number);
    seen_[vertex].residuals[axis] = static_cast<std::uint16_t>(std::abs(residual));
  }
  // Then, of all axes of the piece: the class, and any number of as many bits as the largest.
  void done(std::uint32_t vertex, std::uint32_t bits, std::uint32_t digits) {
    coded_[vertex] = static_cast<std::uint16_t>(256 * (std::bit_width(2 * digits + 1) - 1) + bits);
    previous_ = bits;
  }
  // Forgets what was coded of these pieces.
  void forget(const std::vector<BasisPiece>& pieces) {
    for (const BasisPiece& piece : pieces) {
      seen_[piece.vertex] = {};
      coded_[piece.vertex] = 0;
    }
  }

 private:
  struct Seen {
    std::array<std::int16_t, 3> numbers{};
    std::array<std::uint16_t, 3> residuals{};  // magnitudes
  };
  static constexpr std::uint32_t magnitudes = 17;  // bits of the largest number there is, and 0

  std::vector<Seen> seen_;
  // The class of a vertex, plus 256 times the bits of its largest number: in one word, as what was written in two
  // cannot be read in one before it has reached the cache.
  std::vector<std::uint16_t> coded_;
  std::size_t nobody_;
  std::array<std::uint8_t, magnitudes*(2 * 16 + 1)> contexts_;
  std::uint32_t previous_ = 0;
  int largest_ = 0;
};

// A column in a group.
struct ColumnPlace {
  std::uint32_t group = 0, index = 0;
};

// Where each column lies, by ascending groups: the order in which they are coded.
std::vector<std::vector<ColumnPlace>> column_places(const PackedModel& model);

}  // namespace fb
