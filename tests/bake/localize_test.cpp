#include "bake/regions/localize.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/random.h"
#include "base/status.h"
#include "test_models.h"

using namespace fb;

namespace {

constexpr std::uint32_t side = 24, feature_count = 20, direct_count = 4, region_outputs = 30, poses = 200;

// A grid with two regions of local bumps that overlap in the middle, and a strip that no region moves. Regions are one
// linear layer, so that their coefficients in a pose are plain to compute; their groups of rows cut through vertices.
FaceModel bumpy_model() {
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

std::vector<float> features_of(std::uint64_t pose) {
  Random random(17, pose);
  std::vector<float> values(feature_count);
  for (float& value : values) value = random.uniform();
  return values;
}

std::vector<float> coefficients_of(const Network& network, const std::vector<float>& features) {
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

std::vector<float> displacements_of(const FaceModel& model, const std::vector<float>& coefficients) {
  std::vector<double> sums(model.basis.rows, 0);
  for (const RowGroup& group : model.basis.groups)
    for (std::size_t c = 0; c < group.columns.size(); ++c)
      for (std::uint32_t i = 0; i < group.row_count; ++i) {
        const std::uint32_t row = group.first_row + i;
        const std::size_t at = model.basis.order.empty() ? row : 3 * model.basis.order[row / 3] + row % 3;
        sums[at] += double(group.values[c * group.row_count + i]) * coefficients[group.columns[c]];
      }
  return {sums.begin(), sums.end()};
}

std::vector<std::vector<float>> covariances(const Network& network) {
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

Difference difference(const FaceModel& a, const FaceModel& b) {
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

// Of columns and last layers.
std::size_t numbers_in(const FaceModel& model) {
  std::size_t count = model.basis.value_count();
  for (const Region& region : model.network.regions)
    count += region.layers.back().weights.size() + region.layers.back().bias.size();
  return count;
}

// A direct column by vertex, whatever the order.
std::vector<float> direct_column(const FaceModel& model, std::size_t column) {
  std::vector<float> coefficients(model.basis.columns, 0);
  coefficients[column] = 1;
  return displacements_of(model, coefficients);
}

}  // namespace

TEST_CASE("with threshold 0 nothing moves otherwise") {
  const FaceModel model = bumpy_model();
  // A vertex has three directions, fewer than there are columns.
  const LocalizedModel local = localize_basis(model, covariances(model.network), {.chunk_vertices = 1, .threshold = 0});
  for (const Region& region : local.model.network.regions) CHECK(region.layers.back().outputs > region_outputs);
  CHECK(difference(model, local.model).worst < 1e-6);

  const Basis& basis = local.model.basis;
  std::vector<std::uint32_t> order = basis.order;
  std::sort(order.begin(), order.end());
  for (std::uint32_t v = 0; v < side * side; ++v) REQUIRE(order[v] == v);
  for (const RowGroup& group : basis.groups) CHECK(group.row_count == 3);
  CHECK(numbers_in(local.model) < numbers_in(model));

  for (std::size_t d = 0; d < direct_count; ++d) CHECK(direct_column(model, d) == direct_column(local.model, d));
  for (const RowGroup& group : basis.groups)
    for (std::size_t c = 0; c < group.columns.size() && group.columns[c] < direct_count; ++c) {
      const auto first = group.values.begin() + std::ptrdiff_t(c * group.row_count);
      CHECK(std::any_of(first, first + group.row_count, [](float value) { return value != 0; }));
    }
}

TEST_CASE("a threshold loses what theory says, and leaves fewer numbers") {
  const FaceModel model = bumpy_model();
  const auto covariance = covariances(model.network);
  std::size_t last = numbers_in(model);
  for (const double threshold : {1e-5, 1e-4, 1e-3}) {
    const LocalizedModel local = localize_basis(model, covariance, {.threshold = threshold});
    CHECK(numbers_in(local.model) < last);
    CHECK(local.model.basis.groups.size() <= side * side / 64 + 3);  // one not full in each region, and outside
    last = numbers_in(local.model);
    // At worst every direction lost moves a vertex by the threshold, as often as there are columns.
    const Difference lost = difference(model, local.model);
    CHECK(lost.rms > 0);
    CHECK(lost.rms < threshold * std::sqrt(2.0 * region_outputs));

    // Coefficients of one group only, of the size told.
    std::set<std::uint32_t> seen;
    for (const RowGroup& group : local.model.basis.groups)
      for (const std::uint32_t column : group.columns)
        if (column >= direct_count) CHECK(seen.insert(column).second);
    CHECK(seen.size() + direct_count == local.model.basis.columns);
    REQUIRE(local.coefficient_sizes.size() == local.model.basis.columns);
    std::vector<double> squares(local.model.basis.columns, 0);
    for (std::uint64_t pose = 0; pose < poses; ++pose) {
      const std::vector<float> c = coefficients_of(local.model.network, features_of(pose));
      for (std::size_t k = 0; k < c.size(); ++k) squares[k] += double(c[k]) * c[k] / poses;
    }
    for (std::size_t k = direct_count; k < squares.size(); ++k)
      CHECK(std::sqrt(squares[k]) == doctest::Approx(local.coefficient_sizes[k]).epsilon(1e-2));
  }
}

TEST_CASE("regions that would not shrink keep their columns, those too still are left out") {
  FaceModel model = bumpy_model();
  const auto covariance = covariances(model.network);
  DenseLayer& last = model.network.regions[0].layers.back();
  const FaceModel linear = model;
  last.activation = Activation::relu;
  const LocalizedModel kept = localize_basis(model, covariance, {.threshold = 1e-4});
  CHECK(kept.model.network.regions[0].layers.back().weights == last.weights);
  CHECK(kept.model.network.regions[1].layers.back().outputs != region_outputs);
  CHECK(kept.coefficient_sizes[direct_count] == doctest::Approx(std::sqrt(covariance[0][0])));
  FaceModel compared = kept.model;  // the same columns, so coefficients of the linear layer show them
  compared.network.regions[0].layers.back().activation = Activation::linear;
  CHECK(difference(linear, compared).worst < 2e-3);

  // 12 directions in each of so many chunks, and an output each, are more than the columns were.
  const LocalizedModel whole = localize_basis(linear, covariance, {.chunk_vertices = 4, .threshold = 0});
  CHECK(whole.model.network.regions[0].layers.back().outputs == region_outputs);
  CHECK(difference(linear, whole.model).worst < 1e-6);

  const LocalizedModel still = localize_basis(linear, covariance, {.threshold = 1});
  CHECK(still.model.network.regions.empty());
  CHECK(still.model.basis.columns == direct_count);
}

TEST_CASE("localized models localize again, the same on any threads, and bad covariances are refused") {
  const FaceModel model = bumpy_model();
  auto covariance = covariances(model.network);
  const LocalizedModel once = localize_basis(model, covariance, {}, {.threads = 1});
  const LocalizedModel other = localize_basis(model, covariance, {}, {.threads = 3});
  CHECK(once.model.basis.order == other.model.basis.order);
  for (std::size_t g = 0; g < once.model.basis.groups.size(); ++g)
    CHECK(once.model.basis.groups[g].values == other.model.basis.groups[g].values);
  CHECK(once.model.network.regions[1].layers.back().weights == other.model.network.regions[1].layers.back().weights);

  const LocalizedModel twice =
      localize_basis(once.model, covariances(once.model.network), {.chunk_vertices = 40, .threshold = 0});
  CHECK(difference(once.model, twice.model).worst < 1e-6);

  covariance[1].pop_back();
  CHECK_THROWS_AS(localize_basis(model, covariance, {}), Error);
  covariance[1].push_back(NAN);
  CHECK_THROWS_AS(localize_basis(model, covariance, {}), Error);
  covariance.pop_back();
  CHECK_THROWS_AS(localize_basis(model, covariance, {}), Error);
  CHECK_THROWS_AS(localize_basis(model, covariances(model.network), {.chunk_vertices = 0}), Error);
}
