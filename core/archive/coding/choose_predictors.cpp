#include "archive/coding/choose_predictors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace fb::archive {
namespace {

// The numbers of one column by slots and axes.
using Numbers = std::vector<std::array<std::int16_t, 3>>;

// About as many bits as a residual takes beyond those that every residual takes.
class Bits {
 public:
  Bits() {
    for (std::size_t r = 0; r < table_.size(); ++r) table_[r] = of_magnitude(static_cast<int>(r));
  }
  float of(int residual) const {
    const int magnitude = std::abs(residual);
    return magnitude < static_cast<int>(table_.size()) ? table_[static_cast<std::size_t>(magnitude)]
                                                       : of_magnitude(magnitude);
  }

 private:
  static float of_magnitude(int magnitude) {
    const auto r = static_cast<float>(magnitude);
    return 0.5f * std::log2(1 + 2 * r * r);
  }
  std::array<float, 256> table_;
};

// A piece, what its numbers may be predicted from, and the bits that each pair of predictors takes.
struct Candidates {
  std::vector<Predictor> predictors;
  std::vector<std::array<std::uint32_t, 2>> pairs;
  std::vector<float> bits;
};

int predicted(const Predictor& prediction, const Numbers& numbers, std::size_t axis) {
  return numbers[prediction.left][axis] + numbers[prediction.right][axis] - numbers[prediction.across][axis];
}

class Chooser {
 public:
  explicit Chooser(const PackedModel& model) : model_(model), places_(column_places(model)) {
    pieces_ = basis_pieces(model.rest, static_cast<std::uint32_t>(model.rest.vertex_count()), model.order, model.groups,
                           [&](BasisPiece& piece, std::span<const Predictor> predictors) {
                             choose_pair(piece, predictors, 0);
                             candidates_.push_back({{predictors.begin(), predictors.end()}, {}, {}});
                           });
    std::size_t first = 0;
    for (const auto& pieces : pieces_) {
      first_.push_back(first);
      first += pieces.size();
    }
  }

  // Each prediction alone first, then pairs of the best.
  std::vector<std::vector<BasisPiece>> chosen() {
    for (Candidates& c : candidates_) {
      c.pairs.clear();
      for (std::uint32_t g = 0; g < c.predictors.size(); ++g) c.pairs.push_back({g, g});
    }
    weigh();
    for (Candidates& c : candidates_) {
      std::vector<std::uint32_t> order(c.predictors.size());
      for (std::uint32_t g = 0; g < order.size(); ++g) order[g] = g;
      std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return c.bits[a] < c.bits[b]; });
      c.pairs = {{0, 0}};
      const std::size_t best = std::min(best_guesses, order.size());
      for (std::size_t a = 0; a < best; ++a)
        for (std::size_t b = a; b < best; ++b)
          if (order[a] + order[b] > 0) c.pairs.push_back({std::min(order[a], order[b]), std::max(order[a], order[b])});
    }
    weigh();
    std::size_t at = 0;
    for (auto& pieces : pieces_)
      for (BasisPiece& piece : pieces) {
        Candidates& c = candidates_[at++];
        for (std::size_t p = 1; p < c.pairs.size(); ++p) c.bits[p] += choice_bits;
        const auto least = std::min_element(c.bits.begin(), c.bits.end()) - c.bits.begin();
        const auto [first, second] = c.pairs[static_cast<std::size_t>(least)];
        choose_pair(piece, c.predictors, pair_number(first, second));
      }
    return std::move(pieces_);
  }

 private:
  static constexpr std::size_t best_guesses = 3;
  static constexpr float choice_bits = 4;  // that another choice than the first prediction takes

  // Sums up the bits of all pairs over all columns.
  void weigh() {
    for (Candidates& c : candidates_) c.bits.assign(c.pairs.size(), 0);
    Numbers numbers(model_.rest.vertex_count() + 1);
    for (const std::vector<ColumnPlace>& places : places_) {
      for (const ColumnPlace& place : places)
        each_piece(place, [&](const BasisPiece& piece, const std::int16_t* values, Candidates&) {
          std::copy_n(values, piece.count, numbers[piece.slot].begin() + piece.axis);
        });
      for (const ColumnPlace& place : places)
        each_piece(place, [&](const BasisPiece& piece, const std::int16_t* values, Candidates& c) {
          for (std::size_t p = 0; p < c.pairs.size(); ++p) {
            const Predictor &one = c.predictors[c.pairs[p][0]], &other = c.predictors[c.pairs[p][1]];
            for (std::size_t i = 0; i < piece.count; ++i) {
              const std::size_t axis = piece.axis + i;
              const int sum = predicted(one, numbers, axis) + predicted(other, numbers, axis);
              c.bits[p] += bits_.of(values[i] - ((sum + 1) >> 1));
            }
          }
        });
      for (const ColumnPlace& place : places)
        for (const BasisPiece& piece : pieces_[place.group]) numbers[piece.slot] = {};
    }
  }

  // Calls with(piece, its values, its candidates).
  template <class With>
  void each_piece(const ColumnPlace& place, const With& with) {
    const PackedRowBlock& group = model_.groups[place.group];
    const std::int16_t* const values = group.values.data() + std::size_t(place.index) * group.row_count;
    std::size_t at = first_[place.group];
    for (const BasisPiece& piece : pieces_[place.group]) with(piece, values + piece.row, candidates_[at++]);
  }

  const PackedModel& model_;
  const Bits bits_;
  std::vector<std::vector<ColumnPlace>> places_;
  std::vector<std::vector<BasisPiece>> pieces_;
  std::vector<std::size_t> first_;  // of the candidates of each group
  std::vector<Candidates> candidates_;
};

}  // namespace

std::vector<std::vector<BasisPiece>> best_pieces(const PackedModel& model) {
  return Chooser(model).chosen();
}

}  // namespace fb::archive
