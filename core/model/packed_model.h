// A face in whole numbers: what an archive stores and a reader evaluates. core/bake/quantize makes it of a FaceModel;
// core/archive/FORMAT.md says what is computed from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "model/mesh.h"
#include "model/network.h"
#include "model/rig_schema.h"

namespace fb {

// Whole numbers of 8 bits lie in -127..127, those of 16 bits in -32512..32512, so that such a number is 256 * high +
// low with both digits in -128..127.
inline constexpr int largest_narrow = 127, largest_wide = 32512;

// The two digits of a whole number.
constexpr int low_digit(int number) {
  return ((number + 128) & 255) - 128;
}
constexpr int high_digit(int number) {
  return (number - low_digit(number)) / 256;
}

// Numbers summed in one row at most, so that a sum of digits times 1 fits 32 bits.
inline constexpr std::uint32_t most_summands = 0xffffff;

// y = activation(scales[o] * (W x)[o] + bias[o]), plus x where `skip`.
struct PackedLayer {
  std::uint32_t inputs = 0, outputs = 0;
  Activation activation = Activation::linear;
  bool skip = false;
  bool wide = false;                  // weights of 16 bits
  std::vector<std::int16_t> weights;  // outputs x inputs, row after row
  std::vector<float> scales, bias;    // outputs
};

struct PackedRegion {
  std::string name;
  std::vector<std::uint32_t> features;
  std::vector<PackedLayer> layers;
  Gate gate;
};

// A column of a row group: scale * values is what one unit of the coefficient moves.
struct PackedColumn {
  std::uint32_t column = 0;
  bool wide = false;
  float scale = 0;
};

struct PackedRowBlock {
  std::uint32_t first_row = 0, row_count = 0;
  std::vector<PackedColumn> columns;  // ascending
  std::vector<std::int16_t> values;   // column after column, row_count numbers each
};

struct PackedModel {
  RigSchema schema;
  Mesh rest;
  std::vector<Feature> features;
  std::vector<std::uint32_t> direct;
  std::vector<PackedRegion> regions;
  std::uint32_t columns = 0;           // of the basis: the number of coefficients
  std::vector<std::uint32_t> order;    // see Basis::order
  std::vector<PackedRowBlock> groups;  // ascending, without gaps or overlaps, covering 3 x vertices rows
  std::string provenance;              // a JSON object; read by people and `inspect`

  std::size_t parameter_count() const;  // weights and biases
  std::size_t value_count() const;      // of the basis
  // Which of the rest mesh's coordinates a row of the basis moves.
  std::size_t coordinate(std::uint32_t row) const {
    return order.empty() ? row : 3 * std::size_t(order[row / 3]) + row % 3;
  }
};

// The numbers of a column of a group multiplied out: what one unit of the coefficient moves, row by row.
std::vector<float> displacements(const PackedRowBlock& group, std::size_t column);

// Checks every part and that they fit each other; fails by name.
void check(const PackedModel& model);

}  // namespace fb
