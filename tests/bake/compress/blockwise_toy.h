// A face of two overlapping regions with local bases, small enough to be computed plainly in tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "base/random.h"
#include "model/packed_model.h"
#include "test_models.h"

namespace fb {

inline constexpr std::uint32_t side = 24, feature_count = 20, direct_count = 4, region_outputs = 30, poses = 40;

// A grid with two regions of local bumps that overlap in the middle, and a strip that no region moves. Regions are one
// linear layer, so that their coefficients in a pose are plain to compute; their groups of rows cut through vertices.
inline FaceModel bumpy_model() {
  Random random(3);
  FaceModel model;
  model.rest = grid_mesh(side, side);
  for (std::uint32_t c = 0; c < feature_count; ++c) {
    model.schema.controls.push_back({"control" + std::to_string(c), 0, 1, 0, ""});
    model.network.features.push_back({.kind = Feature::Kind::identity, .control = c});
  }
  for (std::uint32_t d = 0; d < direct_count; ++d) model.network.direct.push_back(3 * d);
  std::vector<float> dense;
  for (std::uint32_t d = 0; d < direct_count; ++d)
    for (std::size_t i = 0; i < 3 * side * side; ++i) dense.push_back(i / 3 / side == 5 * d ? random.uniform() : 0.0f);
  for (std::uint32_t r = 0; r < 2; ++r) {
    Region region{r ? "right" : "left", {}, {}};
    for (std::uint32_t f = 0; f < feature_count; ++f) region.features.push_back(f);
    region.layers = {random_layer(random, feature_count, region_outputs, Activation::linear, false)};
    model.network.regions.push_back(region);
    for (std::uint32_t k = 0; k < region_outputs; ++k) {
      const float x = random.uniform(r ? 11.0f : 0.0f, r ? float(side) : 13.0f), y = random.uniform(0, float(side) - 3);
      float way[3];
      for (float& component : way) component = random.uniform(-0.1f, 0.1f);
      for (std::uint32_t v = 0; v < side * side; ++v) {
        const float dx = float(v % side) - x, dy = float(v / side) - y, apart = dx * dx + dy * dy;
        const bool inside = (r ? v % side >= 10 : v % side < 14) && v / side < side - 2;
        for (const float component : way) dense.push_back(inside ? component * std::exp(-apart / 20) : 0.0f);
      }
    }
  }
  model.basis = make_basis(3 * side * side, direct_count + 2 * region_outputs, dense);
  model.provenance = "{}";
  check(model);
  return model;
}

inline std::vector<float> features_of(std::uint64_t pose) {
  Random random(17, pose);
  std::vector<float> values(feature_count);
  for (float& value : values) value = random.uniform();
  return values;
}

inline std::vector<float> coefficients_of(const Network& network, const std::vector<float>& features) {
  std::vector<float> coefficients;
  for (const std::uint32_t f : network.direct) coefficients.push_back(features[f]);
  for (const Region& region : network.regions) {
    const DenseLayer& layer = region.layers.back();
    for (std::uint32_t o = 0; o < layer.outputs; ++o) {
      double sum = layer.bias[o];
      for (std::uint32_t i = 0; i < layer.inputs; ++i)
        sum += double(layer.weights[o * layer.inputs + i]) * features[region.features[i]];
      coefficients.push_back(float(sum));
    }
  }
  return coefficients;
}

inline std::vector<float> displacements_of(const FaceModel& model, const std::vector<float>& coefficients) {
  std::vector<double> sums(model.basis.rows, 0);
  for (const RowBlock& group : model.basis.row_blocks)
    for (std::size_t c = 0; c < group.columns.size(); ++c)
      for (std::uint32_t i = 0; i < group.row_count; ++i) {
        const std::uint32_t row = group.first_row + i;
        const std::size_t at = model.basis.order.empty() ? row : 3 * model.basis.order[row / 3] + row % 3;
        sums[at] += double(group.values[c * group.row_count + i]) * coefficients[group.columns[c]];
      }
  return {sums.begin(), sums.end()};
}

inline std::vector<std::vector<float>> covariances(const Network& network) {
  std::vector<std::vector<float>> result;
  std::size_t first = network.direct.size();
  for (const Region& region : network.regions) {
    const std::size_t n = region.layers.back().outputs;
    std::vector<double> sums(n * n, 0);
    for (std::uint64_t pose = 0; pose < poses; ++pose) {
      const std::vector<float> c = coefficients_of(network, features_of(pose));
      for (std::size_t i = 0; i < n * n; ++i) sums[i] += double(c[first + i / n]) * c[first + i % n] / poses;
    }
    result.emplace_back(sums.begin(), sums.end());
    first += n;
  }
  return result;
}

struct Difference {
  double rms = 0, worst = 0;  // distance of a vertex, over the diagonal
};

// Between two faces over the poses.
inline Difference difference(const FaceModel& a, const FaceModel& b) {
  Difference result;
  for (std::uint64_t pose = 0; pose < poses; ++pose) {
    const std::vector<float> features = features_of(pose);
    const std::vector<float> x = displacements_of(a, coefficients_of(a.network, features));
    const std::vector<float> y = displacements_of(b, coefficients_of(b.network, features));
    for (std::size_t v = 0; v < x.size() / 3; ++v) {
      double squared = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) squared += std::pow(double(x[3 * v + axis]) - y[3 * v + axis], 2);
      result.rms += squared / double(poses * x.size() / 3);
      result.worst = std::max(result.worst, std::sqrt(squared));
    }
  }
  const double diagonal = a.rest.diagonal();
  return {std::sqrt(result.rms) / diagonal, result.worst / diagonal};
}

// The whole numbers of a packed model multiplied out.
inline FaceModel unpacked(const PackedModel& packed) {
  FaceModel model{packed.schema, packed.rest, {packed.features, packed.direct, {}}, {}, packed.provenance};
  for (const PackedRegion& region : packed.regions) {
    Region& plain = model.network.regions.emplace_back(Region{region.name, region.features, {}, region.gate});
    for (const PackedLayer& layer : region.layers) {
      plain.layers.push_back({layer.inputs, layer.outputs, layer.activation, layer.skip, {}, layer.bias});
      for (std::size_t i = 0; i < layer.weights.size(); ++i)
        plain.layers.back().weights.push_back(layer.scales[i / layer.inputs] * float(layer.weights[i]));
    }
  }
  model.basis = {std::uint32_t(packed.rest.points.size()), packed.columns, {}, packed.order};
  for (const PackedRowBlock& group : packed.row_blocks) {
    RowBlock& plain = model.basis.row_blocks.emplace_back(RowBlock{group.first_row, group.row_count, {}, {}});
    for (const PackedColumn& column : group.columns) plain.columns.push_back(column.column);
    for (std::size_t i = 0; i < group.values.size(); ++i)
      plain.values.push_back(group.columns[i / group.row_count].scale * float(group.values[i]));
  }
  return model;
}

}  // namespace fb
