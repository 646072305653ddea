#include "archive/coding/writer/choose_predictors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace fb::archive {
namespace {

// The values of one column by rank and axis.
using ColumnValues = std::vector<std::array<std::int16_t, 3>>;

// Estimated bits of a residual, up to a constant.
class ResidualBits {
 public:
  ResidualBits() {
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

// The candidate predictors of a unit, and the estimated bits of each pair under consideration.
struct Candidates {
  std::vector<Predictor> predictors;
  std::vector<std::array<std::uint32_t, 2>> pairs;
  std::vector<float> bits;
};

int predicted(const Predictor& predictor, const ColumnValues& values, std::size_t axis) {
  return values[predictor.left][axis] + values[predictor.right][axis] - values[predictor.across][axis];
}

class PredictorChooser {
 public:
  explicit PredictorChooser(const PackedModel& model) : model_(model), segments_(column_segments(model)) {
    units_ = coding_units(model.rest, static_cast<std::uint32_t>(model.rest.vertex_count()), model.order,
                          model.row_blocks, [&](CodingUnit& unit, std::span<const Predictor> predictors) {
                            set_predictors(unit, predictors, 0);
                            candidates_.push_back({{predictors.begin(), predictors.end()}, {}, {}});
                          });
    std::size_t first = 0;
    for (const auto& units : units_) {
      first_.push_back(first);
      first += units.size();
    }
  }

  // Measures each predictor alone, then the pairs of the best.
  CodingUnits choose() {
    for (Candidates& c : candidates_) {
      c.pairs.clear();
      for (std::uint32_t p = 0; p < c.predictors.size(); ++p) c.pairs.push_back({p, p});
    }
    measure_bits();
    for (Candidates& c : candidates_) pair_best(c);
    measure_bits();
    std::size_t at = 0;
    for (auto& units : units_)
      for (CodingUnit& unit : units) {
        Candidates& c = candidates_[at++];
        for (std::size_t p = 1; p < c.pairs.size(); ++p) c.bits[p] += pair_bits;
        const auto least = std::min_element(c.bits.begin(), c.bits.end()) - c.bits.begin();
        const auto [first, second] = c.pairs[static_cast<std::size_t>(least)];
        set_predictors(unit, c.predictors, pair_index(first, second));
      }
    return std::move(units_);
  }

 private:
  static constexpr std::size_t paired_predictors = 3;  // the best that are paired: trades time for size
  static constexpr float pair_bits = 4;                // estimated cost of coding another pair than (0, 0)

  // Replaces the candidates' pairs by (0, 0) and all pairs of the best predictors.
  static void pair_best(Candidates& c) {
    std::vector<std::uint32_t> order(c.predictors.size());
    for (std::uint32_t p = 0; p < order.size(); ++p) order[p] = p;
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return c.bits[a] < c.bits[b]; });
    c.pairs = {{0, 0}};
    const std::size_t best = std::min(paired_predictors, order.size());
    for (std::size_t a = 0; a < best; ++a)
      for (std::size_t b = a; b < best; ++b)
        if (order[a] + order[b] > 0) c.pairs.push_back({std::min(order[a], order[b]), std::max(order[a], order[b])});
  }

  // Adds up the bits of all pairs over all columns.
  void measure_bits() {
    for (Candidates& c : candidates_) c.bits.assign(c.pairs.size(), 0);
    ColumnValues column(model_.rest.vertex_count() + 1);
    for (const auto& segments : segments_) {
      for (const ColumnSegment& segment : segments)
        for_each_unit(segment, [&](const CodingUnit& unit, const std::int16_t* values, Candidates&) {
          std::copy_n(values, unit.count, column[unit.rank].begin() + unit.axis);
        });
      for (const ColumnSegment& segment : segments)
        for_each_unit(segment, [&](const CodingUnit& unit, const std::int16_t* values, Candidates& c) {
          for (std::size_t p = 0; p < c.pairs.size(); ++p) {
            const Predictor &first = c.predictors[c.pairs[p][0]], &second = c.predictors[c.pairs[p][1]];
            for (std::size_t i = 0; i < unit.count; ++i) {
              const std::size_t axis = unit.axis + i;
              const int sum = predicted(first, column, axis) + predicted(second, column, axis);
              c.bits[p] += residual_bits_.of(values[i] - ((sum + 1) >> 1));
            }
          }
        });
      for (const ColumnSegment& segment : segments)
        for (const CodingUnit& unit : units_[segment.block]) column[unit.rank] = {};
    }
  }

  // Calls function(unit, its values, its candidates).
  template <class Function>
  void for_each_unit(const ColumnSegment& segment, const Function& function) {
    const PackedRowBlock& block = model_.row_blocks[segment.block];
    const std::int16_t* const values = block.values.data() + std::size_t(segment.index) * block.row_count;
    std::size_t at = first_[segment.block];
    for (const CodingUnit& unit : units_[segment.block]) function(unit, values + unit.row, candidates_[at++]);
  }

  const PackedModel& model_;
  const ResidualBits residual_bits_;
  ColumnSegments segments_;
  CodingUnits units_;
  std::vector<std::size_t> first_;  // index in candidates_ of the first unit of each row block
  std::vector<Candidates> candidates_;
};

}  // namespace

CodingUnits choose_predictors(const PackedModel& model) {
  return PredictorChooser(model).choose();
}

}  // namespace fb::archive
