#include "bake/compress/rate_distortion.h"

#include <cmath>

#include "archive/coding/basis_symbols.h"
#include "archive/coding/choose_predictors.h"

namespace fb::bake {
namespace {

// Calls with(state, piece, group, offset of the column's values) for all pieces as they are coded, which must
// tell the state what was made of the piece.
template <class With>
void piece_by_piece(const PackedModel& model, const std::vector<std::vector<archive::BasisPiece>>& pieces,
                    With&& with) {
  archive::ColumnState state(model.rest.vertex_count());
  for (const std::vector<archive::ColumnPlace>& places : archive::column_places(model)) {
    for (const auto& [g, index] : places) {
      const PackedRowBlock& group = model.groups[g];
      state.begin_place(group.columns[index].wide);
      for (const archive::BasisPiece& piece : pieces[g])
        with(state, piece, g, std::size_t(index) * group.row_count + piece.row);
    }
    for (const archive::ColumnPlace& place : places) state.forget(pieces[place.group]);
  }
}

// Counts symbols; then says what one costs.
class Costs {
 public:
  void symbol(std::size_t context, std::uint32_t value) { ++of_[256 * context + value]; }
  void bits(std::uint32_t, std::uint32_t) {}

  void settle() {
    for (std::size_t context = 0; context < archive::basis_contexts; ++context) {
      float* const of = &of_[256 * context];
      float sum = 0;
      for (std::size_t value = 0; value < 256; ++value) sum += of[value] += 0.01f;  // nothing is impossible
      for (std::size_t value = 0; value < 256; ++value) of[value] = std::log2(sum / of[value]);
    }
  }
  float of(std::size_t context, std::uint32_t value) const { return of_[256 * context + value]; }

 private:
  std::vector<float> of_ = std::vector<float>(256 * archive::basis_contexts);
};

struct Price {
  void symbol(std::size_t context, std::uint32_t value) { bits_ += costs_.of(context, value); }
  void bits(std::uint32_t count, std::uint32_t) { bits_ += static_cast<float>(count); }
  const Costs& costs_;
  float bits_ = 0;
};

// The first tells what symbols cost where they are chosen so, and from which predictors vertices are predicted best
// then.
constexpr int rounds = 2;

// What symbols cost in the model as it is.
Costs costs_in(const PackedModel& model, const std::vector<std::vector<archive::BasisPiece>>& pieces) {
  Costs costs;
  piece_by_piece(model, pieces,
                 [&](archive::ColumnState& state, const archive::BasisPiece& piece, std::uint32_t g, std::size_t at) {
                   const archive::AxisNumbers numbers = archive::numbers_of(state, piece, &model.groups[g].values[at]),
                                              residuals = archive::residuals_of(state, piece, numbers);
                   archive::code_piece(costs, state, piece, residuals);
                   state.set(piece.slot, numbers, residuals, archive::class_of(residuals));
                 });
  costs.settle();
  return costs;
}

}  // namespace

void rate_distortion_quantise(PackedModel& model, const std::vector<std::vector<float>>& exact, double bits_per_step) {
  std::vector<std::vector<std::int16_t>> nearest;
  for (const PackedRowBlock& group : model.groups) nearest.push_back(group.values);
  for (int round = 0; round < rounds; ++round) {
    const auto pieces = archive::best_pieces(model);
    const Costs costs = costs_in(model, pieces);
    piece_by_piece(model, pieces,
                   [&](archive::ColumnState& state, const archive::BasisPiece& piece, std::uint32_t g, std::size_t at) {
                     const float* const value = exact[g].data() + at - piece.axis;  // by axis
                     archive::AxisNumbers numbers = archive::numbers_of(state, piece, &nearest[g][at]),
                                          residuals = archive::residuals_of(state, piece, numbers);
                     const std::uint32_t first = piece.axis, end = first + piece.count;
                     const auto price = [&](archive::AxisNumbers changes) {
                       Price sum{costs};
                       double squares = 0;
                       archive::AxisNumbers changed = residuals;
                       for (std::uint32_t axis = first; axis < end; ++axis) {
                         changed[axis] += changes[axis];
                         const double off = double(numbers[axis] + changes[axis]) - value[axis];
                         squares += off * off;
                       }
                       archive::code_piece(sum, state, piece, changed);
                       return sum.bits_ + bits_per_step * squares;
                     };
                     // A row may go one step towards what is predicted for it, if it does not come a whole step from
                     // its value.
                     archive::AxisNumbers towards{}, best{};
                     for (std::uint32_t axis = first; axis < end; ++axis) {
                       const int change = residuals[axis] > 0 ? -1 : residuals[axis] < 0 ? 1 : 0;
                       if (std::fabs(numbers[axis] + change - value[axis]) < 1) towards[axis] = change;
                     }
                     if (archive::class_of(towards) > 0) {
                       double least = price(best);
                       for (int rows = 1; rows < 8; ++rows) {
                         archive::AxisNumbers changes{};
                         for (std::size_t axis = 0; axis < 3; ++axis)
                           if (rows >> axis & 1) changes[axis] = towards[axis];
                         const double cost = price(changes);
                         if (cost < least) least = cost, best = changes;
                       }
                     }
                     for (std::uint32_t axis = first; axis < end; ++axis) {
                       numbers[axis] += best[axis];
                       residuals[axis] += best[axis];
                       model.groups[g].values[at + axis - first] = static_cast<std::int16_t>(numbers[axis]);
                     }
                     state.set(piece.slot, numbers, residuals, archive::class_of(residuals));
                   });
  }
}

}  // namespace fb::bake
