#include "model/packed_model.h"

#include <algorithm>
#include <cmath>

#include "base/checked.h"
#include "model/basis.h"
#include "model/network_check.h"

namespace fb {
namespace {

// Without an early exit, so that the loop vectorises.
bool all_within(const std::int16_t* values, std::size_t count, int largest) {
  std::int16_t lowest = 0, highest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    lowest = std::min(lowest, values[i]);
    highest = std::max(highest, values[i]);
  }
  return lowest >= -largest && highest <= largest;
}

void check_packed_values(const PackedLayer& layer, const LayerPlace& place) {
  if (layer.weights.size() != checked_multiply(layer.inputs, layer.outputs, place.region) ||
      layer.bias.size() != layer.outputs || layer.scales.size() != layer.outputs)
    fail(Status::bad_data, "%s is %u x %u and has %zu weights, %zu scales, %zu biases", place.text().c_str(),
         layer.outputs, layer.inputs, layer.weights.size(), layer.scales.size(), layer.bias.size());
  if (layer.inputs > max_row_inputs)
    fail(Status::limit, "%s has %u inputs; at most %u are supported", place.text().c_str(), layer.inputs,
         max_row_inputs);
  if (!all_within(layer.weights.data(), layer.weights.size(), layer.wide ? largest_wide : largest_narrow))
    fail(Status::bad_data, "%s holds a weight beyond its range", place.text().c_str());
  if (!all_finite(layer.scales) || !all_finite(layer.bias))
    fail(Status::not_finite, "%s holds a scale or bias that is not finite", place.text().c_str());
}

void check_row_block(const PackedRowBlock& block, std::size_t index, std::uint32_t columns) {
  std::size_t inputs = 0;
  if (block.values.size() != checked_multiply(block.columns.size(), block.row_count, "basis row block"))
    fail(Status::bad_data, "basis: row block %zu has %zu values for %zu columns of %u rows", index, block.values.size(),
         block.columns.size(), block.row_count);
  for (std::size_t c = 0; c < block.columns.size(); ++c) {
    const PackedColumn& column = block.columns[c];
    if (column.column >= columns || (c > 0 && column.column <= block.columns[c - 1].column))
      fail(Status::bad_data, "basis: row block %zu lists column %u out of order or range", index, column.column);
    if (!std::isfinite(column.scale * (column.wide ? 256.0f : 1.0f)))
      fail(Status::not_finite, "basis: row block %zu has a scale that is not finite in column %u", index,
           column.column);
    if (!all_within(block.values.data() + c * block.row_count, block.row_count,
                    column.wide ? largest_wide : largest_narrow))
      fail(Status::bad_data, "basis: row block %zu holds a value beyond its range in column %u", index, column.column);
    inputs += column.wide ? 2 : 1;
  }
  if (inputs > max_row_inputs)
    fail(Status::limit, "basis: row block %zu has %zu inputs; at most %u are supported", index, inputs, max_row_inputs);
}

// Fails if a row block has vertices of two parts of the mesh, which could not be posed without each other, or of the
// surface and of what carries numbers.
void check_blocks_of_parts(const PackedModel& model) {
  const std::vector<std::uint32_t> ends = model.rest.part_ends();
  if (ends.size() < 2) return;
  const auto part_of = [&](std::uint32_t row) {
    return std::upper_bound(ends.begin(), ends.end(), static_cast<std::uint32_t>(model.coordinate(row) / 3)) -
           ends.begin();
  };
  for (std::size_t b = 0; b < model.row_blocks.size(); ++b) {
    const PackedRowBlock& block = model.row_blocks[b];
    const auto part = part_of(block.first_row);
    for (std::uint32_t row = block.first_row + 1; row < block.first_row + block.row_count; ++row)
      if (part_of(row) != part) fail(Status::bad_data, "basis: row block %zu has vertices of two meshes", b);
  }
}

// Fails unless the vertices that carry numbers are as many as these need, at rest 0 and last in every order.
void check_carriers(const PackedModel& model) {
  const std::size_t channels = model.schema.channels.size(), numbers = model.rest.driven.number_count();
  const std::size_t first = model.rest.surface_vertex_count();
  if (model.rest.driven.scales.size() != numbers ||
      model.rest.carrier_vertices != (channels + 2) / 3 + (numbers + 2) / 3)
    fail(Status::bad_data, "%u vertices carry %zu channels and %zu numbers of driven joints",
         model.rest.carrier_vertices, channels, numbers);
  for (const Channel& c : model.schema.channels)
    if (!std::isfinite(c.scale) || !(c.scale > 0))
      fail(Status::bad_data, "channel \"%s\" has the scale %g, which is not above 0", c.name.c_str(), double(c.scale));
  for (std::size_t v = first; v < model.rest.vertex_count(); ++v) {
    if (!model.order.empty() && v < model.order.size() && model.order[v] != v)
      fail(Status::bad_data, "the order lists vertices behind those that carry numbers");
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (model.rest.points[3 * v + axis] != 0)
        fail(Status::bad_data, "a vertex that carries numbers is not 0 at rest");
  }
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
  for (const PackedRowBlock& block : row_blocks) count += block.values.size();
  return count;
}

int low_digit_bits(const std::int16_t* values, std::size_t count) {
  int largest = 0, bits = 1;
  for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, std::abs(int(values[i])));
  while (largest > largest_narrow << bits) ++bits;
  return bits;
}

std::vector<float> displacements(const PackedRowBlock& block, std::size_t column) {
  const auto first = block.values.begin() + column * block.row_count;
  std::vector<float> moved(first, first + block.row_count);
  for (float& value : moved) value *= block.columns[column].scale;
  return moved;
}

void check(const PackedModel& model) {
  check(model.schema);
  check(model.rest);
  check_carriers(model);
  check_features(model.features, model.schema.control_count());
  check_direct(model.direct, model.features);
  check_regions(model.regions, model.features, check_packed_values);
  std::size_t coefficients = model.direct.size();
  for (const PackedRegion& region : model.regions) coefficients += region.layers.back().outputs;
  if (model.columns != coefficients)
    fail(Status::bad_data, "the basis has %u columns for %zu coefficients", model.columns, coefficients);
  const std::size_t rows = model.rest.points.size();
  std::size_t row = 0;
  for (std::size_t i = 0; i < model.row_blocks.size(); ++i) {
    const PackedRowBlock& block = model.row_blocks[i];
    if (block.first_row != row || block.row_count == 0)
      fail(Status::bad_data, "basis: row block %zu begins at row %u, not %zu, or is empty", i, block.first_row, row);
    row += block.row_count;
    check_row_block(block, i, model.columns);
  }
  if (row != rows) fail(Status::bad_data, "basis: row blocks cover %zu rows of %zu coordinates", row, rows);
  check_order(model.order, rows);
  check_blocks_of_parts(model);
  check(model.expected, model.schema, model.rest.surface_vertex_count());
  check(model.exact, model.schema, rows);
  check_levels(model);
}

}  // namespace fb
