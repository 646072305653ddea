#include "bake/measure/float_face.h"

#include <algorithm>
#include <cmath>

#include "bake/rig/driven_pose.h"
#include "model/activation.h"
#include "model/feature_values.h"

namespace fb::bake {
namespace {

double activated(Activation activation, double value) {
  switch (activation) {
    case Activation::linear:
      break;
    case Activation::relu:
      return std::max(value, 0.0);
    case Activation::tanh:
      return rational_tanh(static_cast<float>(value));
    case Activation::silu:
      return rational_silu(static_cast<float>(value));
  }
  return value;
}

double gate_value_of(const Gate& gate, std::span<const float> features) {
  if (gate.features.empty()) return 1;
  double sum = 0, most = 0;
  for (const std::uint32_t f : gate.features) {
    sum += std::abs(features[f]);
    most = std::max<double>(most, std::abs(features[f]));
  }
  return std::clamp(gate.slope * (sum - most), 0.0, 1.0);
}

}  // namespace

FloatFace::FloatFace(const FaceModel& model) : model_(model), rest_controls_(model.schema.rest_pose()) {
  check(model);
  const std::vector<float> nothing(model.network.features.size());
  for (const Region& region : model.network.regions) at_rest_.push_back(run(region, nothing));
}

std::vector<double> FloatFace::run(const Region& region, std::span<const float> features) const {
  std::vector<double> x, y;
  for (const std::uint32_t f : region.features) x.push_back(features[f]);
  for (const DenseLayer& layer : region.layers) {
    y.assign(layer.bias.begin(), layer.bias.end());
    for (std::size_t o = 0; o < layer.outputs; ++o) {
      const float* weights = layer.weights.data() + o * layer.inputs;
      for (std::size_t i = 0; i < layer.inputs; ++i) y[o] += weights[i] * x[i];
      y[o] = activated(layer.activation, y[o]) + (layer.skip ? x[o] : 0);
    }
    x.swap(y);
  }
  return x;
}

std::vector<double> FloatFace::coefficients(std::span<const float> controls) const {
  std::vector<float> within(controls.begin(), controls.end()), features(model_.network.features.size());
  for (std::size_t c = 0; c < within.size(); ++c)
    within[c] = std::clamp(within[c], model_.schema.controls[c].minimum, model_.schema.controls[c].maximum);
  feature_values(model_.network.features, within.data(), rest_controls_.data(), features.data());
  std::vector<double> coefficients;
  for (const std::uint32_t f : model_.network.direct) coefficients.push_back(features[f]);
  for (std::size_t r = 0; r < at_rest_.size(); ++r) {
    const Region& region = model_.network.regions[r];
    const double gate_value = gate_value_of(region.gate, features);
    std::vector<double> posed = run(region, features);
    for (std::size_t i = 0; i < posed.size(); ++i) coefficients.push_back((posed[i] - at_rest_[r][i]) * gate_value);
  }
  return coefficients;
}

std::vector<double> FloatFace::evaluate(std::span<const float> controls) const {
  const Basis& basis = model_.basis;
  const std::vector<double> weights = coefficients(controls);
  std::vector<double> positions(model_.rest.points.begin(), model_.rest.points.end());
  std::vector<double> moved;
  for (const RowBlock& group : basis.row_blocks) {
    moved.assign(group.row_count, 0);
    for (std::size_t c = 0; c < group.columns.size(); ++c) {
      const double weight = weights[group.columns[c]];
      const float* values = group.values.data() + c * group.row_count;
      if (weight != 0)
        for (std::size_t r = 0; r < group.row_count; ++r) moved[r] += weight * values[r];
    }
    for (std::size_t r = 0; r < group.row_count; ++r) {
      const std::size_t row = group.first_row + r;
      positions[basis.order.empty() ? row : 3 * std::size_t(basis.order[row / 3]) + row % 3] += moved[r];
    }
  }
  if (!model_.rest.driven.empty()) {
    const std::size_t surface = 3 * model_.rest.surface_vertex_count(), numbers = model_.rest.first_joint_coordinate();
    const std::vector<float> coordinates(positions.begin() + std::ptrdiff_t(numbers), positions.end());
    add_driven_skin(model_.rest, joint_motions(model_.rest.driven, coordinates), std::span(positions).first(surface));
  }
  return positions;
}

}  // namespace fb::bake
