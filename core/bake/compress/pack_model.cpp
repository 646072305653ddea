#include "bake/compress/pack_model.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/status.h"

namespace fb::bake {
namespace {

constexpr float least = 0x1p-100f;  // magnitudes below are 0

// What has few bits takes few bytes, in the scale of a row or in a bias: the upper `bits` of 32 are kept, away from 0
// or to the nearest.
float with_few_bits(float value, int bits, bool away) {
  const std::uint32_t unit = 1u << (32 - bits);
  const std::uint32_t more = std::bit_cast<std::uint32_t>(value) + (away ? unit - 1 : unit / 2);
  const auto rounded = std::bit_cast<float>(more & ~(unit - 1));
  return std::isfinite(rounded) ? rounded : value;
}
constexpr int scale_bits = 16;  // sign, exponent and 7 of the significand: up to 0.8 % more than would do

float magnitude(const float* values, std::size_t count) {
  float most = 0;
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, std::fabs(values[i]));
  return most;
}

// Appends `count` values as multiples of one scale, the smallest with which they stay in -largest..largest, but at
// least `step`.
float append_rounded(const float* values, std::size_t count, int largest, float step, std::vector<std::int16_t>& to) {
  const float most = magnitude(values, count);
  const float scale =
      most < least ? 0 : with_few_bits(std::max(most / static_cast<float>(largest), step), scale_bits, true);
  for (std::size_t i = 0; i < count; ++i) {
    const double steps = scale == 0 ? 0 : std::nearbyint(double(values[i]) / scale);
    to.push_back(static_cast<std::int16_t>(std::clamp(steps, -double(largest), double(largest))));
  }
  return scale;
}

PackedLayer pack_layer(const DenseLayer& layer, int bits) {
  if (bits != 16 && (bits < 2 || bits > 8))
    fail(Status::invalid_argument, "weights of %d bits; there are 2 to 8, and 16", bits);
  PackedLayer packed{layer.inputs, layer.outputs, layer.activation, layer.skip, bits == 16, {}, {}, {}};
  for (const float bias : layer.bias) packed.bias.push_back(with_few_bits(bias, packed.wide ? 24 : 16, false));
  packed.weights.reserve(layer.weights.size());
  for (std::size_t o = 0; o < layer.outputs; ++o)
    packed.scales.push_back(append_rounded(layer.weights.data() + o * layer.inputs, layer.inputs,
                                           packed.wide ? largest_wide : (1 << (bits - 1)) - 1, 0, packed.weights));
  return packed;
}

PackedRegion pack_region(const Region& region, const PackOptions& options) {
  PackedRegion packed{region.name, region.features, {}, region.gate};
  for (std::size_t l = 0; l < region.layers.size(); ++l) {
    const int bits = l + 1 == region.layers.size() ? options.output_bits
                     : l == 0                      ? options.first_bits
                                                   : options.hidden_bits;
    packed.layers.push_back(pack_layer(region.layers[l], bits));
  }
  return packed;
}

// What a column's values may be rounded by, how small their root mean square may be before the column is dropped, and
// the step they need not be finer than, in units of values.
struct Allowance {
  double rounding, drop, step;
};

// The coordinates as multiples of a power of two of at most 2^-20 D, or a quarter of what the basis is rounded by, but
// never above 2^-16 D: what archives keep in a third of the bytes or less, and no position is off by more than half of
// it. Those that a float could not hold so stay as they are.
Mesh on_grid(const Mesh& mesh, double basis_step) {
  Mesh out = mesh;
  const double diagonal = mesh.diagonal();
  const int finest = std::ilogb(diagonal) - 20, coarsest = std::ilogb(diagonal) - 16;
  const float step =
      std::ldexp(1.0f, basis_step > 0 ? std::clamp(std::ilogb(basis_step / 4 * diagonal), finest, coarsest) : finest);
  const bool fits = std::isnormal(step) && std::all_of(mesh.points.begin(), mesh.points.end(),
                                                       [&](float x) { return std::fabs(double(x)) < 0x1p23 * step; });
  if (fits)
    for (float& x : out.points) x = static_cast<float>(std::nearbyint(double(x) / step) * step) + 0.0f;
  return out;
}

// `exact`: what the values are rounded from, in steps.
PackedRowBlock pack_row_block(const RowBlock& group, const std::vector<Allowance>& allowances,
                              std::vector<float>& exact) {
  PackedRowBlock packed{group.first_row, group.row_count, {}, {}};
  for (std::size_t c = 0; c < group.columns.size(); ++c) {
    const Allowance& allowed = allowances[group.columns[c]];
    const auto first = group.values.begin() + c * group.row_count;
    std::vector<float> values(first, first + group.row_count);
    const float most = magnitude(values.data(), values.size());
    double squares = 0;
    for (const float value : values) squares += double(value) * value;
    if (most < least || most < allowed.step / 2) continue;
    if (squares < allowed.drop * allowed.drop * static_cast<double>(values.size())) continue;
    const bool wide = most / largest_narrow / 2 > allowed.rounding;
    const float scale = append_rounded(values.data(), values.size(), wide ? largest_wide : largest_narrow,
                                       static_cast<float>(allowed.step), packed.values);
    packed.columns.push_back({group.columns[c], wide, scale});
    for (const float value : values) exact.push_back(scale == 0 ? 0 : value / scale);
  }
  return packed;
}

}  // namespace

PackedModel pack_model(const FaceModel& model, const PackOptions& options) {
  check(model);
  if (!options.coefficient_sizes.empty() && options.coefficient_sizes.size() != model.basis.columns)
    fail(Status::invalid_argument, "%zu coefficient sizes for %u coefficients", options.coefficient_sizes.size(),
         model.basis.columns);
  PackedModel packed;
  packed.schema = model.schema;
  packed.rest = on_grid(model.rest, options.step);
  packed.features = model.network.features;
  packed.direct = model.network.direct;
  for (const Region& region : model.network.regions) packed.regions.push_back(pack_region(region, options));
  packed.columns = model.basis.columns;
  packed.order = model.basis.order;
  packed.provenance = model.provenance;

  const double diagonal = model.rest.diagonal();
  std::vector<Allowance> allowances;
  for (std::uint32_t column = 0; column < model.basis.columns; ++column) {
    const double size = options.coefficient_sizes.empty() ? 1 : options.coefficient_sizes[column];
    constexpr double any = std::numeric_limits<double>::infinity();  // of a coefficient that is always 0
    const double unit = diagonal / size;
    allowances.push_back(size > 0 ? Allowance{options.basis_tolerance * unit, options.drop * unit, options.step * unit}
                                  : Allowance{any, 0, 0});
  }
  std::vector<std::vector<float>> exact;
  for (const RowBlock& group : model.basis.row_blocks)
    packed.row_blocks.push_back(pack_row_block(group, allowances, exact.emplace_back()));
  if (options.step > 0) rate_distortion_quantise(packed, exact, options.step_lambda);
  check(packed);
  return packed;
}

}  // namespace fb::bake
