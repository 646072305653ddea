#include "model/packed_model.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"
#include "model/basis.h"
#include "model/network_check.h"

namespace fb {
namespace {

// Looks at all of them, which is quicker than to stop at the first: side by side.
bool all_within(const std::int16_t* values, std::size_t count, int largest) {
  std::int16_t least = 0, most = 0;
  for (std::size_t i = 0; i < count; ++i) {
    least = std::min(least, values[i]);
    most = std::max(most, values[i]);
  }
  return least >= -largest && most <= largest;
}

void check_values(const PackedLayer& layer, const char* where) {
  if (layer.weights.size() != checked_multiply(layer.inputs, layer.outputs, where) ||
      layer.bias.size() != layer.outputs || layer.scales.size() != layer.outputs)
    fail(Status::bad_data, "%s is %u x %u and has %zu weights, %zu scales, %zu biases", where, layer.outputs,
         layer.inputs, layer.weights.size(), layer.scales.size(), layer.bias.size());
  if (layer.inputs > most_summands)
    fail(Status::limit, "%s has %u inputs; at most %u can be summed", where, layer.inputs, most_summands);
  if (!all_within(layer.weights.data(), layer.weights.size(), layer.wide ? largest_wide : largest_narrow))
    fail(Status::bad_data, "%s holds a weight beyond its range", where);
  if (!all_finite(layer.scales) || !all_finite(layer.bias))
    fail(Status::not_finite, "%s holds a scale or bias that is not finite", where);
}

void check_group(const PackedRowBlock& group, std::size_t g, std::uint32_t columns) {
  std::size_t summands = 0;
  if (group.values.size() != checked_multiply(group.columns.size(), group.row_count, "basis row group"))
    fail(Status::bad_data, "basis: row group %zu has %zu values for %zu columns of %u rows", g, group.values.size(),
         group.columns.size(), group.row_count);
  for (std::size_t c = 0; c < group.columns.size(); ++c) {
    const PackedColumn& column = group.columns[c];
    if (column.column >= columns || (c > 0 && column.column <= group.columns[c - 1].column))
      fail(Status::bad_data, "basis: row group %zu lists column %u out of order or range", g, column.column);
    if (!std::isfinite(column.scale * (column.wide ? 256.0f : 1.0f)))
      fail(Status::not_finite, "basis: row group %zu has a scale that is not finite in column %u", g, column.column);
    if (!all_within(group.values.data() + c * group.row_count, group.row_count,
                    column.wide ? largest_wide : largest_narrow))
      fail(Status::bad_data, "basis: row group %zu holds a value beyond its range in column %u", g, column.column);
    summands += column.wide ? 2 : 1;
  }
  if (summands > most_summands)
    fail(Status::limit, "basis: row group %zu has %zu summands; at most %u can be summed", g, summands, most_summands);
}

}  // namespace

std::size_t PackedModel::parameter_count() const {
  std::size_t count = 0;
  for (const PackedRegion& region : regions)
    for (const PackedLayer& layer : region.layers) count += layer.weights.size() + layer.bias.size();
  return count;
}

std::size_t PackedModel::value_count() const {
  std::size_t count = 0;
  for (const PackedRowBlock& group : groups) count += group.values.size();
  return count;
}

std::vector<float> displacements(const PackedRowBlock& group, std::size_t column) {
  const auto first = group.values.begin() + column * group.row_count;
  std::vector<float> moved(first, first + group.row_count);
  for (float& value : moved) value *= group.columns[column].scale;
  return moved;
}

void check(const PackedModel& model) {
  check(model.schema);
  check(model.rest);
  check_features(model.features, model.schema.control_count());
  check_direct(model.direct, model.features);
  check_regions(model.regions, model.features, check_values);
  std::size_t coefficients = model.direct.size();
  for (const PackedRegion& region : model.regions) coefficients += region.layers.back().outputs;
  if (model.columns != coefficients)
    fail(Status::bad_data, "the basis has %u columns for %zu coefficients", model.columns, coefficients);
  const std::size_t rows = model.rest.points.size();
  std::size_t row = 0;
  for (std::size_t g = 0; g < model.groups.size(); ++g) {
    const PackedRowBlock& group = model.groups[g];
    if (group.first_row != row || group.row_count == 0)
      fail(Status::bad_data, "basis: row group %zu begins at row %u, not %zu, or is empty", g, group.first_row, row);
    row += group.row_count;
    check_group(group, g, model.columns);
  }
  if (row != rows) fail(Status::bad_data, "basis: row groups cover %zu rows of %zu coordinates", row, rows);
  check_order(model.order, rows);
}

}  // namespace fb
