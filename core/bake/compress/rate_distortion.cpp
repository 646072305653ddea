#include "bake/compress/rate_distortion.h"

#include <cmath>

#include "archive/coding/writer/choose_predictors.h"
#include "archive/coding/writer/unit_symbols.h"

namespace fb::bake {
namespace {

using archive::AxisVector;
using archive::CodingUnit;
using archive::ColumnHistory;
using archive::ColumnSegment;

using Units = archive::CodingUnits;

// Calls function(history, unit, row block, index of the unit's first value in the block) for all units of all columns
// in coding order. The function records in `history` what the unit is coded as.
template <class Function>
void for_each_unit(const PackedModel& model, const Units& units, Function&& function) {
  ColumnHistory history(model.rest.vertex_count());
  for (const auto& segments : archive::column_segments(model)) {
    for (const auto& [b, index] : segments) {
      const PackedRowBlock& block = model.row_blocks[b];
      history.begin_segment(block.columns[index].wide);
      for (const CodingUnit& unit : units[b])
        function(history, unit, b, std::size_t(index) * block.row_count + unit.row);
    }
    for (const ColumnSegment& segment : segments) history.clear(units[segment.block]);
  }
}

// Counts symbols as a sink of write_unit; finish() turns the counts into bits per symbol.
class SymbolCosts {
 public:
  void symbol(std::size_t context, std::uint32_t value) { ++costs_[256 * context + value]; }
  void bits(std::uint32_t, std::uint32_t) {}

  void finish() {
    for (std::size_t context = 0; context < archive::basis_contexts; ++context) {
      float* const costs = &costs_[256 * context];
      float sum = 0;
      for (std::size_t value = 0; value < 256; ++value) sum += costs[value] += 0.01f;  // symbols that did not occur
      for (std::size_t value = 0; value < 256; ++value) costs[value] = std::log2(sum / costs[value]);
    }
  }
  float bits_of(std::size_t context, std::uint32_t value) const { return costs_[256 * context + value]; }

 private:
  std::vector<float> costs_ = std::vector<float>(256 * archive::basis_contexts);
};

// Adds up the bits of the symbols written, as a sink of write_unit.
struct BitCounter {
  void symbol(std::size_t context, std::uint32_t value) { total += costs.bits_of(context, value); }
  void bits(std::uint32_t count, std::uint32_t) { total += static_cast<float>(count); }
  const SymbolCosts& costs;
  float total = 0;
};

// The cost of symbols in the model as it is quantised now.
SymbolCosts measure_costs(const PackedModel& model, const Units& units) {
  SymbolCosts costs;
  for_each_unit(model, units, [&](ColumnHistory& history, const CodingUnit& unit, std::uint32_t b, std::size_t at) {
    const AxisVector values = archive::values_of_vertex(history, unit, &model.row_blocks[b].values[at]),
                     residuals = archive::residuals_of(history, unit, values);
    archive::write_unit(costs, history, unit, residuals);
    history.set(unit.rank, values, residuals, archive::class_of(residuals));
  });
  costs.finish();
  return costs;
}

// Chooses the values of one unit.
struct UnitQuantiser {
  const SymbolCosts& costs;
  double lambda;
  const ColumnHistory& history;
  const CodingUnit& unit;
  const float* exact;            // by axis; read only on the unit's axes
  AxisVector values, residuals;  // rounded to nearest

  std::uint32_t first() const { return unit.axis; }
  std::uint32_t end() const { return std::uint32_t(unit.axis) + unit.count; }

  // Rate + lambda * distortion if values and residuals change so.
  double cost(AxisVector changes) const {
    BitCounter counter{costs};
    double squares = 0;
    AxisVector changed = residuals;
    for (std::uint32_t axis = first(); axis < end(); ++axis) {
      changed[axis] += changes[axis];
      const double error = double(values[axis] + changes[axis]) - exact[axis];
      squares += error * error;
    }
    archive::write_unit(counter, history, unit, changed);
    return counter.total + lambda * squares;
  }

  // By axis, a change by one towards the prediction, or 0 where the residual is 0 or the value would be a whole step
  // from `exact`.
  AxisVector possible_changes() const {
    AxisVector changes{};
    for (std::uint32_t axis = first(); axis < end(); ++axis) {
      const int change = residuals[axis] > 0 ? -1 : residuals[axis] < 0 ? 1 : 0;
      if (std::fabs(values[axis] + change - exact[axis]) < 1) changes[axis] = change;
    }
    return changes;
  }

  // Applies that subset of the possible changes which costs least.
  void quantise() {
    const AxisVector possible = possible_changes();
    if (archive::class_of(possible) == 0) return;
    AxisVector best{};
    double least = cost(best);
    for (int subset = 1; subset < 8; ++subset) {
      AxisVector changes{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        if (subset >> axis & 1) changes[axis] = possible[axis];
      const double with_changes = cost(changes);
      if (with_changes < least) least = with_changes, best = changes;
    }
    values += best;
    residuals += best;
  }
};

// Costs and predictors depend on the values and these on costs and predictors: the second round uses those of the
// first.
constexpr int rounds = 2;

}  // namespace

void rate_distortion_quantise(PackedModel& model, const std::vector<std::vector<float>>& exact, double lambda) {
  std::vector<std::vector<std::int16_t>> nearest;
  for (const PackedRowBlock& block : model.row_blocks) nearest.push_back(block.values);
  for (int round = 0; round < rounds; ++round) {
    const Units units = archive::choose_predictors(model);
    const SymbolCosts costs = measure_costs(model, units);
    for_each_unit(model, units, [&](ColumnHistory& history, const CodingUnit& unit, std::uint32_t b, std::size_t at) {
      const AxisVector values = archive::values_of_vertex(history, unit, &nearest[b][at]);
      UnitQuantiser quantiser{costs,
                              lambda,
                              history,
                              unit,
                              exact[b].data() + at - unit.axis,
                              values,
                              archive::residuals_of(history, unit, values)};
      quantiser.quantise();
      for (std::uint32_t i = 0; i < unit.count; ++i)
        model.row_blocks[b].values[at + i] = static_cast<std::int16_t>(quantiser.values[unit.axis + i]);
      history.set(unit.rank, quantiser.values, quantiser.residuals, archive::class_of(quantiser.residuals));
    });
  }
}

}  // namespace fb::bake
