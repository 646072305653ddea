// How the numbers of a basis are predicted and in which contexts they are coded: what reader and writer of the section
// "basis values" share. FORMAT.md describes it.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
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
inline constexpr std::uint32_t class_contexts = 52, most_class = 16, residual_contexts = 4 * 9;
inline constexpr std::uint32_t basis_contexts = class_contexts + residual_contexts;
inline constexpr std::uint32_t coded_bits = 6;  // of a residual's magnitude; what is finer is stored as bits

inline constexpr std::size_t class_lane = 3;  // residuals are coded in lane 0, 1, 2

// What is known of one column while it is coded: numbers and classes of all vertices, 0 where not coded yet.
class ColumnState {
 public:
  explicit ColumnState(std::size_t vertices) : numbers_(4 * (vertices + 1)), seen_(vertices + 1), vertices_(vertices) {
    for (std::uint32_t sum = 0; sum <= 2 * most_class; ++sum)
      for (std::uint32_t most = 0; most < magnitudes; ++most)
        contexts_[magnitudes * sum + most] = static_cast<std::uint8_t>(
            sum == 0 ? most > 0 : 1 + std::min(sum, 20u) + (most > (sum + 1) / 2 + 2 ? 20 : 0));
  }

  // What row `axis` of the piece is foretold to be, in -largest..largest.
  int foretold(const BasisPiece& piece, std::size_t axis, int largest) const {
    const int sum = at(piece.left, axis) + at(piece.right, axis) - at(piece.across, axis);
    return std::clamp((sum + piece.halved) >> piece.halved, -largest, largest);
  }

  std::uint32_t class_context(const BasisPiece& piece) const {
    if (piece.last == vertices_) return 42 + std::min<std::uint32_t>(previous_, 9);
    const std::uint32_t first = seen_[piece.last], second = seen_[piece.last_but_one];
    return contexts_[magnitudes * (first % 256 + second % 256) + std::max(first / 256, second / 256)];
  }

  static std::uint32_t residual_context(std::uint32_t bits, bool last, bool reached) {
    return class_contexts + 4 * (std::min(bits, 9u) - 1) + 2 * last + reached;
  }

  void set(std::uint32_t vertex, std::size_t axis, int number) {
    numbers_[4 * std::size_t(vertex) + axis] = static_cast<std::int16_t>(number);
  }
  // Once a piece is coded: the class of its residuals and the largest magnitude of its numbers.
  void done(std::uint32_t vertex, std::uint32_t bits, std::uint32_t magnitude) {
    seen_[vertex] = static_cast<std::uint16_t>(256 * (std::bit_width(2 * magnitude + 1) - 1) + bits);
    previous_ = bits;
  }
  void begin_group() { previous_ = 0; }
  // Forgets what was coded of these pieces.
  void forget(const std::vector<BasisPiece>& pieces) {
    for (const BasisPiece& piece : pieces) {
      std::fill_n(numbers_.begin() + 4 * std::size_t(piece.vertex), 4, std::int16_t(0));
      seen_[piece.vertex] = 0;
    }
  }

 private:
  static constexpr std::uint32_t magnitudes = 17;  // bits of the largest number there is, and 0
  int at(std::uint32_t vertex, std::size_t axis) const { return numbers_[4 * std::size_t(vertex) + axis]; }

  std::vector<std::int16_t> numbers_;  // four a vertex, the last of them unused
  // The class of a vertex' residuals, plus 256 times the bits of its largest number: in one word, as what was written
  // in two cannot be read in one before it has reached the cache.
  std::vector<std::uint16_t> seen_;
  std::size_t vertices_;
  std::array<std::uint8_t, magnitudes*(2 * most_class + 1)> contexts_;
  std::uint32_t previous_ = 0;
};

// A column in a group.
struct ColumnPlace {
  std::uint32_t group = 0, index = 0;
};

// Where each column lies, by ascending groups: the order in which they are coded.
std::vector<std::vector<ColumnPlace>> column_places(const PackedModel& model);

}  // namespace fb
