// The quantised face model: what an archive stores and the runtime evaluates. core/bake/compress/pack_model quantises a
// FaceModel; core/archive/EVALUATION.md defines the evaluation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <string>
#include <vector>

#include "model/character.h"
#include "model/detail_levels.h"
#include "model/exact_poses.h"
#include "model/expected_errors.h"
#include "model/mesh.h"
#include "model/network.h"
#include "model/rig_schema.h"

namespace fb {

// Quantised values: narrow ones (8 bits) are in -127..127, wide ones (16 bits) in -32512..32512, so that a wide value
// is 256 * high + low with both digits in -128..127.
inline constexpr int largest_narrow = 127, largest_wide = 32512;

// The two signed digits of a value whose low digit has so many bits, 1 to 8.
constexpr int low_digit(int number, int bits = 8) {
  const int half = 1 << (bits - 1);
  return ((number + half) & (2 * half - 1)) - half;
}
constexpr int high_digit(int number, int bits = 8) {
  return (number + (1 << (bits - 1))) >> bits;
}
// Bits of the low digits of a wide column of a row block: as few as leave high digits of at most 127, and at least 1.
// Its inputs for high digits are 2^bits times those for low ones, and all inputs of a row block are rounded to
// multiples of one step, so a fixed 256 would round columns of a few hundred steps as coarsely as one of 32,512: by up
// to half of a step of their own.
int low_digit_bits(const std::int16_t* values, std::size_t count);

// The largest number of inputs of a matrix row: a sum of so many digits fits 32 bits.
inline constexpr std::uint32_t max_row_inputs = 0xffffff;

// y = activation(scales[o] * (W x)[o] + bias[o]), plus x if `skip`.
struct PackedLayer {
  std::uint32_t inputs = 0, outputs = 0;
  Activation activation = Activation::linear;
  bool skip = false;
  bool wide = false;                  // 16-bit weights
  std::pmr::vector<std::int16_t> weights;  // outputs x inputs, row-major
  std::vector<float> scales, bias;    // outputs
};

// See Region.
struct PackedRegion {
  std::string name;
  std::vector<std::uint32_t> features;
  std::vector<PackedLayer> layers;
  Gate gate;
};

// A column of a row block: scale * values is the displacement for one unit of the coefficient.
struct PackedColumn {
  std::uint32_t column = 0;
  bool wide = false;
  float scale = 0;
};

// Consecutive rows of the basis that use the same coefficients.
struct PackedRowBlock {
  std::uint32_t first_row = 0, row_count = 0;
  std::pmr::vector<PackedColumn> columns;  // ascending
  std::pmr::vector<std::int16_t> values;   // column-major: row_count values a column
};

struct PackedModel {
  RigSchema schema;
  Mesh rest;
  std::vector<Feature> features;
  std::vector<std::uint32_t> direct;
  std::vector<PackedRegion> regions;
  std::uint32_t columns = 0;               // of the basis: the number of coefficients
  std::vector<std::uint32_t> order;        // see Basis::order
  std::vector<PackedRowBlock> row_blocks;  // ascending, without gaps or overlaps, covering 3 x vertices rows
  Character character = {};
  ExpectedErrors expected = {};
  std::string provenance;  // a JSON object, for people and `inspect`
  std::vector<ExactPose> exact = {};
  std::vector<DetailLevel> levels = {};  // coarser and coarser; empty: there is only the whole

  std::size_t parameter_count() const;  // weights and biases
  std::size_t value_count() const;      // of the basis
  // The index in rest.points of the coordinate that a row of the basis displaces.
  std::size_t coordinate(std::uint32_t row) const {
    return order.empty() ? row : 3 * std::size_t(order[row / 3]) + row % 3;
  }
};

// scale * values of a column of a row block (`column` counts within the block): row_count displacements.
std::vector<float> displacements(const PackedRowBlock& block, std::size_t column);

// Validates every part and their sizes against each other, except the character; fails with the part's name.
void check(const PackedModel& model);

}  // namespace fb
