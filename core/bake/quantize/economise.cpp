#include "bake/quantize/economise.h"

#include <cmath>

#include "archive/basis_symbols.h"

namespace fb {
namespace {

// Calls with(state, piece, largest, group, offset of the column's values) for all pieces as they are coded, which must
// tell the state what was made of the piece.
template <class With>
void piece_by_piece(const PackedModel& model, const std::vector<std::vector<BasisPiece>>& pieces, With&& with) {
  ColumnState state(model.rest.vertex_count());
  for (const std::vector<ColumnPlace>& places : column_places(model)) {
    for (const auto& [g, index] : places) {
      const PackedRowGroup& group = model.groups[g];
      state.begin_group();
      for (const BasisPiece& piece : pieces[g])
        with(state, piece, group.columns[index].wide ? largest_wide : largest_narrow, g,
             std::size_t(index) * group.row_count + piece.row);
    }
    for (const ColumnPlace& place : places) state.forget(pieces[place.group]);
  }
}

// Counts symbols; then says what one costs.
class Costs {
 public:
  void symbol(std::size_t, std::size_t context, std::uint32_t value) { ++of_[256 * context + value]; }
  void bits(std::size_t, std::uint32_t, std::uint32_t) {}

  void settle() {
    for (std::size_t context = 0; context < basis_contexts; ++context) {
      float* const of = &of_[256 * context];
      float sum = 0;
      for (std::size_t value = 0; value < 256; ++value) sum += of[value] += 0.01f;  // nothing is impossible
      for (std::size_t value = 0; value < 256; ++value) of[value] = std::log2(sum / of[value]);
    }
  }
  float of(std::size_t context, std::uint32_t value) const { return of_[256 * context + value]; }

 private:
  std::vector<float> of_ = std::vector<float>(256 * basis_contexts);
};

struct Price {
  void symbol(std::size_t, std::size_t context, std::uint32_t value) { bits_ += costs_.of(context, value); }
  void bits(std::size_t, std::uint32_t count, std::uint32_t) { bits_ += static_cast<float>(count); }
  const Costs& costs_;
  float bits_ = 0;
};

}  // namespace

void economise(PackedModel& model, const std::vector<std::vector<float>>& exact, double bits_per_step) {
  const auto pieces =
      basis_pieces(model.rest, static_cast<std::uint32_t>(model.rest.vertex_count()), model.order, model.groups);
  Costs costs;
  const auto residuals_of = [](const ColumnState& state, const BasisPiece& piece, int largest,
                               const PieceNumbers& numbers) {
    PieceNumbers residuals{};
    for (std::uint32_t i = 0; i < piece.count; ++i)
      residuals[i] = numbers[i] - state.foretold(piece, piece.axis + i, largest);
    return residuals;
  };
  const auto numbers_at = [&](const BasisPiece& piece, std::uint32_t g, std::size_t at) {
    PieceNumbers numbers{};
    std::copy_n(model.groups[g].values.begin() + static_cast<std::ptrdiff_t>(at), piece.count, numbers.begin());
    return numbers;
  };
  piece_by_piece(
      model, pieces, [&](ColumnState& state, const BasisPiece& piece, int largest, std::uint32_t g, std::size_t at) {
        const PieceNumbers numbers = numbers_at(piece, g, at), residuals = residuals_of(state, piece, largest, numbers);
        code_piece(costs, state, piece, residuals);
        keep_piece(state, piece, numbers, residuals);
      });
  costs.settle();

  piece_by_piece(
      model, pieces, [&](ColumnState& state, const BasisPiece& piece, int largest, std::uint32_t g, std::size_t at) {
        const float* const value = exact[g].data() + at;
        PieceNumbers numbers = numbers_at(piece, g, at), residuals = residuals_of(state, piece, largest, numbers);
        const auto price = [&](const PieceNumbers& changes) {
          Price sum{costs};
          double squares = 0;
          PieceNumbers changed = residuals;
          for (std::uint32_t i = 0; i < piece.count; ++i) {
            changed[i] += changes[i];
            const double off = double(numbers[i] + changes[i]) - value[i];
            squares += off * off;
          }
          code_piece(sum, state, piece, changed);
          return sum.bits_ + bits_per_step * squares;
        };
        // A row may go one step towards what is foretold for it, if it does not come a whole step from its value.
        PieceNumbers towards{}, best{};
        for (std::uint32_t i = 0; i < piece.count; ++i) {
          const int change = residuals[i] > 0 ? -1 : residuals[i] < 0 ? 1 : 0;
          if (std::fabs(numbers[i] + change - value[i]) < 1) towards[i] = change;
        }
        if (towards != PieceNumbers{}) {
          double least = price(best);
          for (int rows = 1; rows < 8; ++rows) {
            PieceNumbers changes{};
            for (int i = 0; i < 3; ++i)
              if (rows >> i & 1) changes[i] = towards[i];
            const double cost = price(changes);
            if (cost < least) least = cost, best = changes;
          }
        }
        for (std::uint32_t i = 0; i < piece.count; ++i) {
          numbers[i] += best[i];
          residuals[i] += best[i];
          model.groups[g].values[at + i] = static_cast<std::int16_t>(numbers[i]);
        }
        keep_piece(state, piece, numbers, residuals);
      });
}

}  // namespace fb
