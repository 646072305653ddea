#include "bake/compress/rate_distortion.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "archive/coding/writer/choose_predictors.h"
#include "archive/coding/writer/segment_tables.h"
#include "archive/coding/writer/unit_symbols.h"

namespace fb::bake {
namespace {

using archive::AxisVector;
using archive::CodingUnit;
using archive::ColumnHistory;
using archive::ColumnSegment;
using archive::for_each_unit;

using Units = archive::CodingUnits;

// Counts symbols as a sink of write_unit; finish() turns the counts into bits per symbol.
class SymbolCosts {
 public:
  void symbol(std::size_t table, std::uint32_t value) { ++costs_[256 * table + value]; }
  void bits(std::uint32_t, std::uint32_t) {}

  void finish() {
    for (std::size_t table = 0; table < table_count; ++table) {
      float* const costs = &costs_[256 * table];
      float sum = 0;
      for (std::size_t value = 0; value < 256; ++value) sum += costs[value] += 0.01f;  // symbols that did not occur
      for (std::size_t value = 0; value < 256; ++value) costs[value] = std::log2(sum / costs[value]);
    }
  }
  float bits_of(std::size_t table, std::uint32_t value) const { return costs_[256 * table + value]; }

 private:
  static constexpr std::size_t table_count = archive::first_class_table + archive::max_class_tables;
  std::vector<float> costs_ = std::vector<float>(256 * table_count);
};

// Adds up the bits of the symbols written, as a sink of write_unit.
struct BitCounter {
  void symbol(std::size_t table, std::uint32_t value) { total += costs.bits_of(table, value); }
  void bits(std::uint32_t count, std::uint32_t) { total += static_cast<float>(count); }
  const SymbolCosts& costs;
  float total = 0;
};

// The cost of symbols in the model as it is quantised now. `tables`: the class tables of segments.
SymbolCosts measure_costs(const PackedModel& model, const Units& units, std::span<const std::uint8_t> tables) {
  SymbolCosts costs;
  std::size_t segments = 0;
  const auto code = [&](ColumnHistory& history, const CodingUnit& unit, std::uint32_t b, std::size_t at) {
    const AxisVector values = archive::values_of_vertex(history, unit, &model.row_blocks[b].values[at]);
    archive::write_unit(costs, tables[segments - 1], unit, archive::residuals_of(history, unit, values));
    history.set(unit.rank, values);
  };
  for_each_unit(
      model, units, [&](std::size_t, const ColumnSegment&) { ++segments; }, code);
  costs.finish();
  return costs;
}

// Chooses the values of one unit.
struct UnitQuantiser {
  const SymbolCosts& costs;
  double lambda;
  std::uint32_t class_table;  // of the segment
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
    archive::write_unit(counter, class_table, unit, changed);
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

// What the values of a segment are rounded from, in steps, after the errors of the columns before it are compensated.
class Targets {
 public:
  Targets(const PackedModel& model, const std::vector<std::vector<float>>& exact,
          const RoundingCompensation* compensation)
      : model_(model), exact_(exact), compensation_(compensation) {
    if (!compensation_) return;
    for (const auto& values : exact) errors_.emplace_back(values.size());
  }

  // The targets of a segment; valid until the next call. Segments of a row block come in order of their index.
  std::span<const float> of(std::uint32_t b, std::uint32_t index) {
    const PackedRowBlock& block = model_.row_blocks[b];
    const std::size_t rows = block.row_count, first = index * rows;
    const auto exact = std::span(exact_[b]).subspan(first, rows);
    if (!compensation_) return exact;
    targets_.assign(exact.begin(), exact.end());
    const PackedColumn& column = block.columns[index];
    if (column.scale == 0) return targets_;
    const std::span<const float> factors = index > 0 ? compensation_->factors(b, index) : std::span<const float>();
    for (std::size_t c = 0; c < index; ++c) {
      const float factor = factors[c] / column.scale;
      const float* const error = &errors_[b][c * rows];
      for (std::size_t i = 0; i < rows; ++i) targets_[i] -= factor * error[i];
    }
    const auto most = static_cast<float>(column.wide ? largest_wide : largest_narrow);
    for (std::size_t i = 0; i < rows; ++i) {
      const bool alone = exact[i] == 0 || std::isnan(targets_[i]);  // not a number: errors too large for floats
      targets_[i] = alone ? exact[i] : std::clamp(targets_[i], -most, most);
    }
    return targets_;
  }

  // Notes the errors of a segment whose values are final.
  void finish(std::uint32_t b, std::uint32_t index) {
    if (!compensation_) return;
    const PackedRowBlock& block = model_.row_blocks[b];
    for (std::size_t i = index * std::size_t(block.row_count), end = i + block.row_count; i < end; ++i)
      errors_[b][i] = (static_cast<float>(block.values[i]) - exact_[b][i]) * block.columns[index].scale;
  }

 private:
  const PackedModel& model_;
  const std::vector<std::vector<float>>& exact_;
  const RoundingCompensation* compensation_;
  std::vector<std::vector<float>> errors_;  // by row block, as its values; in the rig's units
  std::vector<float> targets_;
};

// One round of rate_distortion_quantise.
void quantise_once(PackedModel& model, const std::vector<std::vector<float>>& exact,
                   const RateDistortionOptions& options) {
  const Units units = archive::choose_predictors(model);
  const std::vector<std::uint8_t> tables = archive::choose_segment_tables(model, units);
  const SymbolCosts costs = measure_costs(model, units, tables);
  Targets targets(model, exact, options.compensation);
  std::optional<ColumnSegment> last;
  std::size_t segments = 0;
  std::span<const float> wanted;
  const auto begin = [&](std::size_t, const ColumnSegment& segment) {
    if (last) targets.finish(last->block, last->index);
    last = segment;
    ++segments;
    wanted = targets.of(segment.block, segment.index);
    const auto first =
        model.row_blocks[segment.block].values.begin() + static_cast<std::ptrdiff_t>(segment.index * wanted.size());
    std::transform(wanted.begin(), wanted.end(), first,
                   [](float value) { return static_cast<std::int16_t>(std::nearbyint(value)); });
  };
  for_each_unit(
      model, units, begin, [&](ColumnHistory& history, const CodingUnit& unit, std::uint32_t b, std::size_t at) {
        PackedRowBlock& block = model.row_blocks[b];
        const std::uint32_t vertex = (block.first_row + unit.row) / 3;
        const double weight = options.vertex_weights.empty()
                                  ? 1
                                  : options.vertex_weights[model.order.empty() ? vertex : model.order[vertex]];
        const AxisVector values = archive::values_of_vertex(history, unit, &block.values[at]);
        UnitQuantiser quantiser{costs,
                                options.lambda * weight,
                                tables[segments - 1],
                                unit,
                                wanted.data() + unit.row - unit.axis,
                                values,
                                archive::residuals_of(history, unit, values)};
        quantiser.quantise();
        const AxisVector chosen = quantiser.values;
        for (std::uint32_t i = 0; i < unit.count; ++i)
          block.values[at + i] = static_cast<std::int16_t>(chosen[unit.axis + i]);
        history.set(unit.rank, chosen);
      });
}

// Costs and predictors depend on the values and these on costs and predictors: the second round uses those of the
// first.
constexpr int rounds = 2;

}  // namespace

void rate_distortion_quantise(PackedModel& model, const std::vector<std::vector<float>>& exact,
                              const RateDistortionOptions& options) {
  for (int round = 0; round < rounds; ++round) quantise_once(model, exact, options);
}

}  // namespace fb::bake
