#include "bake/compress/pack_model.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "bake/compress/vertex_spacing.h"
#include "base/status.h"

namespace fb::bake {
namespace {

constexpr float least = 0x1p-100f;  // magnitudes below are 0

// Keeps the upper `bits` of the 32 of a scale or bias, rounded away from 0 or to nearest: the zero bits compress.
float with_few_bits(float value, int bits, bool away) {
  const std::uint32_t unit = 1u << (32 - bits);
  const std::uint32_t more = std::bit_cast<std::uint32_t>(value) + (away ? unit - 1 : unit / 2);
  const auto rounded = std::bit_cast<float>(more & ~(unit - 1));
  return std::isfinite(rounded) ? rounded : value;
}
constexpr int scale_bits = 16;  // sign, exponent and 7 of the significand: scales are up to 0.8 % larger

float magnitude(const float* values, std::size_t count) {
  float most = 0;
  for (std::size_t i = 0; i < count; ++i) most = std::max(most, std::fabs(values[i]));
  return most;
}

// Appends `count` values as multiples of one scale: the smallest with which they are within -largest..largest, at least
// `step`. Returns the scale.
float append_rounded(const float* values, std::size_t count, int largest, float step,
                     std::pmr::vector<std::int16_t>& to) {
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
    // A single layer is a table of a curve: no training has learnt to live with its rounding.
    const int bits = region.layers.size() == 1       ? 16
                     : l + 1 == region.layers.size() ? options.output_bits
                     : l == 0                        ? options.first_bits
                                                     : options.hidden_bits;
    packed.layers.push_back(pack_layer(region.layers[l], bits));
  }
  return packed;
}

// Precision of a column in units of its values: tolerated rounding error, largest value below which the column is
// dropped, smallest quantisation step.
struct ColumnPrecision {
  double rounding, drop, step;
};

// Rounds coordinates to multiples of a power of two: at most 2^-20 D, or a quarter of the basis' step, but at most
// 2^-16 D. Archives then code them in a third of the bytes or less. Coordinates stay as they are if a float could not
// hold the multiples.
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

// `exact`: receives the values before rounding, in steps.
PackedRowBlock pack_row_block(const RowBlock& group, const std::vector<ColumnPrecision>& precisions,
                              std::vector<float>& exact) {
  PackedRowBlock packed{group.first_row, group.row_count, {}, {}};
  for (std::size_t c = 0; c < group.columns.size(); ++c) {
    const ColumnPrecision& precision = precisions[group.columns[c]];
    const auto first = group.values.begin() + c * group.row_count;
    std::vector<float> values(first, first + group.row_count);
    const float most = magnitude(values.data(), values.size());
    if (most < least || most < precision.step / 2 || most < precision.drop) continue;
    const bool wide = most / largest_narrow / 2 > precision.rounding;
    const float scale = append_rounded(values.data(), values.size(), wide ? largest_wide : largest_narrow,
                                       static_cast<float>(precision.step), packed.values);
    packed.columns.push_back({group.columns[c], wide, scale});
    for (const float value : values) exact.push_back(scale == 0 ? 0 : value / scale);
  }
  return packed;
}

// How much smaller the steps of each row block are, a power of two, so that most values at its border are predicted as
// well as inside; and the weights of squared errors by vertex that follow.
struct NormalWeights {
  std::vector<float> of_block, of_vertex;
};

NormalWeights normal_weights(const FaceModel& model, double weight) {
  constexpr float smallest = 1.0f / 8,
                  most = 4;  // of blocks; of vertices beside their block's, and the least is 1 / most
  std::vector<float> wanted = vertex_spacing(model.rest);
  for (float& value : wanted) value = static_cast<float>(std::pow(std::clamp(value, smallest, 1.0f), weight));
  NormalWeights weights;
  weights.of_vertex.resize(wanted.size());
  for (const RowBlock& block : model.basis.row_blocks) {
    const std::uint32_t first = block.first_row / 3, end = (block.first_row + block.row_count + 2) / 3;
    const auto of = [&](std::uint32_t v) { return model.basis.order.empty() ? v : model.basis.order[v]; };
    double squares = 0;
    for (std::uint32_t v = first; v < end; ++v) squares += 1 / (double(wanted[of(v)]) * wanted[of(v)]);
    const double mean = std::sqrt((end - first) / squares);
    const auto step = static_cast<float>(std::exp2(std::nearbyint(std::log2(mean))));
    weights.of_block.push_back(step);
    for (std::uint32_t v = first; v < end; ++v) {
      const float share = step / wanted[of(v)];
      weights.of_vertex[of(v)] = std::clamp(share * share, 1 / most, most);
    }
  }
  return weights;
}

// Values `factor` times as fine, with columns left out that are `drop` times as small.
std::vector<ColumnPrecision> finer(std::vector<ColumnPrecision> precisions, double factor, double drop) {
  for (ColumnPrecision& precision : precisions) {
    precision.rounding *= factor;
    precision.step *= factor;
    precision.drop *= drop;
  }
  return precisions;
}

// Steps of the numbers of driven joints, over those of positions. They are few, but each corrective of controls that
// turn a joint has one, whose errors add up in all that hangs on it.
constexpr double joint_step = 1.0 / 32;

// A row block carries numbers or is of one mesh; those of joints are the last.
bool carries_joints(const FaceModel& model, const RowBlock& block) {
  const std::uint32_t last = (block.first_row + block.row_count - 1) / 3;
  const std::uint32_t vertex = model.basis.order.empty() ? last : model.basis.order[last];
  return 3 * std::size_t{vertex} >= model.rest.first_joint_coordinate();
}

}  // namespace

PackedModel pack_model(const FaceModel& model, const PackOptions& options, const Parallel& parallel) {
  check(model);
  if (!options.coefficient_sizes.empty() && options.coefficient_sizes.size() != model.basis.columns)
    fail(Status::invalid_argument, "%zu coefficient sizes for %u coefficients", options.coefficient_sizes.size(),
         model.basis.columns);
  if (options.samples.size() % std::max<std::size_t>(model.basis.columns, 1) != 0)
    fail(Status::invalid_argument, "%zu samples of %u coefficients", options.samples.size(), model.basis.columns);
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
  std::vector<ColumnPrecision> precisions;
  for (std::uint32_t column = 0; column < model.basis.columns; ++column) {
    const double size = options.coefficient_sizes.empty() ? 1 : options.coefficient_sizes[column];
    constexpr double any = std::numeric_limits<double>::infinity();  // for a coefficient that is always 0
    const double unit = diagonal / size;
    precisions.push_back(size > 0
                             ? ColumnPrecision{options.basis_tolerance * unit, options.drop * unit, options.step * unit}
                             : ColumnPrecision{any, 0, 0});
  }
  std::vector<std::vector<float>> exact;
  NormalWeights weights;
  if (options.normal_weight > 0) weights = normal_weights(model, options.normal_weight);
  for (std::size_t b = 0; b < model.basis.row_blocks.size(); ++b) {
    const bool joints = carries_joints(model, model.basis.row_blocks[b]);
    const double step = joints ? joint_step : weights.of_block.empty() ? 1 : weights.of_block[b];
    packed.row_blocks.push_back(pack_row_block(
        model.basis.row_blocks[b], step == 1 ? precisions : finer(precisions, step, joints ? joint_step : 1),
        exact.emplace_back()));
  }
  if (options.step > 0 && options.rate_distortion) {
    std::optional<RoundingCompensation> compensation;
    if (!options.samples.empty()) compensation.emplace(packed, options.samples, options.coefficient_sizes, parallel);
    rate_distortion_quantise(packed, exact,
                             {options.step_lambda, weights.of_vertex, compensation ? &*compensation : nullptr});
  }
  check(packed);
  return packed;
}

}  // namespace fb::bake
