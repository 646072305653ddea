#include "bake/compress/blockwise_pca.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bake/compress/vertex_blocks.h"
#include "base/status.h"
#include "compress/blockwise_toy.h"
#include "test_models.h"

namespace test_blockwise_pca {

using namespace fb;
using namespace fb::bake;

namespace {

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
  const BlockwiseModel local = blockwise_pca(model, covariances(model.network), {.block_vertices = 1, .threshold = 0});
  for (const Region& region : local.model.network.regions) CHECK(region.layers.back().outputs > region_outputs);
  CHECK(difference(model, local.model).worst < 1e-6);

  const Basis& basis = local.model.basis;
  std::vector<std::uint32_t> order = basis.order;
  std::sort(order.begin(), order.end());
  for (std::uint32_t v = 0; v < side * side; ++v) REQUIRE(order[v] == v);
  for (const RowBlock& group : basis.row_blocks) CHECK(group.row_count == 3);
  CHECK(numbers_in(local.model) < numbers_in(model));

  for (std::size_t d = 0; d < direct_count; ++d) CHECK(direct_column(model, d) == direct_column(local.model, d));
  for (const RowBlock& group : basis.row_blocks)
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
    const BlockwiseModel local = blockwise_pca(model, covariance, {.threshold = threshold});
    CHECK(numbers_in(local.model) < last);
    CHECK(local.model.basis.row_blocks.size() <= side * side / 64 + 3);  // one not full in each region, and outside
    last = numbers_in(local.model);
    // At worst every direction lost moves a vertex by the threshold, as often as there are columns.
    const Difference lost = difference(model, local.model);
    CHECK(lost.rms > 0);
    CHECK(lost.rms < threshold * std::sqrt(2.0 * region_outputs));

    // Coefficients of one group only, of the size told.
    std::set<std::uint32_t> seen;
    for (const RowBlock& group : local.model.basis.row_blocks)
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
  const BlockwiseModel kept = blockwise_pca(model, covariance, {.threshold = 1e-4});
  CHECK(kept.model.network.regions[0].layers.back().weights == last.weights);
  CHECK(kept.model.network.regions[1].layers.back().outputs != region_outputs);
  CHECK(kept.coefficient_sizes[direct_count] == doctest::Approx(std::sqrt(covariance[0][0])));
  FaceModel compared = kept.model;  // the same columns, so coefficients of the linear layer show them
  compared.network.regions[0].layers.back().activation = Activation::linear;
  CHECK(difference(linear, compared).worst < 2e-3);

  // 12 directions in each of so many chunks, and an output each, are more than the columns were.
  const BlockwiseModel whole = blockwise_pca(linear, covariance, {.block_vertices = 4, .threshold = 0});
  CHECK(whole.model.network.regions[0].layers.back().outputs == region_outputs);
  CHECK(difference(linear, whole.model).worst < 1e-6);

  const BlockwiseModel still = blockwise_pca(linear, covariance, {.threshold = 1});
  CHECK(still.model.network.regions.empty());
  CHECK(still.model.basis.columns == direct_count);
}

TEST_CASE("localized models localize again, the same on any threads, and bad covariances are refused") {
  const FaceModel model = bumpy_model();
  auto covariance = covariances(model.network);
  const BlockwiseModel once = blockwise_pca(model, covariance, {}, {.threads = 1});
  const BlockwiseModel other = blockwise_pca(model, covariance, {}, {.threads = 3});
  CHECK(once.model.basis.order == other.model.basis.order);
  for (std::size_t g = 0; g < once.model.basis.row_blocks.size(); ++g)
    CHECK(once.model.basis.row_blocks[g].values == other.model.basis.row_blocks[g].values);
  CHECK(once.model.network.regions[1].layers.back().weights == other.model.network.regions[1].layers.back().weights);

  const BlockwiseModel twice =
      blockwise_pca(once.model, covariances(once.model.network), {.block_vertices = 40, .threshold = 0});
  CHECK(difference(once.model, twice.model).worst < 1e-6);

  covariance[1].pop_back();
  CHECK_THROWS_AS(blockwise_pca(model, covariance, {}), Error);
  covariance[1].push_back(NAN);
  CHECK_THROWS_AS(blockwise_pca(model, covariance, {}), Error);
  covariance.pop_back();
  CHECK_THROWS_AS(blockwise_pca(model, covariance, {}), Error);
  CHECK_THROWS_AS(blockwise_pca(model, covariances(model.network), {.block_vertices = 0}), Error);
}

TEST_CASE("vertices that carry numbers keep their order, whichever region moves them most") {
  Mesh rest = grid_mesh(6, 4);
  rest.carrier_vertices = 5;
  rest.points.resize(rest.points.size() + 15);
  std::vector<std::uint32_t> labels(rest.vertex_count());
  for (std::uint32_t v = 0; v < labels.size(); ++v) labels[v] = (7 * v) % 3;
  std::vector<std::uint32_t> order;
  for (const auto& block : vertex_blocks(rest, labels, 2)) order.insert(order.end(), block.begin(), block.end());
  for (std::uint32_t v = 24; v < 29; ++v) CHECK(order[v] == v);
}

}  // namespace test_blockwise_pca
