#include "bake/compress/pack_model.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "bake/measure/float_face.h"
#include "bake/measure/verify.h"
#include "base/status.h"
#include "test_models.h"

namespace test_pack_model {

using namespace fb;
using namespace fb::bake;

namespace {

// A float model with every kind of feature, all activations, a gate and another order of rows.
FaceModel full_model(std::uint64_t seed) {
  FaceModel model = tiny_model(seed);
  const PackedModel packed = tiny_packed_model(seed);
  Random random(seed, 2);
  model.network.features = packed.features;
  model.network.direct = packed.direct;
  model.network.regions.clear();
  for (const PackedRegion& region : packed.regions) {
    Region& to = model.network.regions.emplace_back(Region{region.name, region.features, {}, region.gate});
    for (const PackedLayer& layer : region.layers)
      to.layers.push_back(random_layer(random, layer.inputs, layer.outputs, layer.activation, layer.skip));
  }
  model.basis.order = packed.order;
  return model;
}

std::vector<float> poses_of(const RigSchema& schema, int count) {
  Random random(5);
  std::vector<float> poses;
  for (int n = 0; n < count; ++n) {
    const std::vector<float> pose = random_pose(schema, random);
    poses.insert(poses.end(), pose.begin(), pose.end());
  }
  return poses;
}

double difference(const FaceModel& model, const PackOptions& options) {
  return quantisation_errors(model, pack_model(model, options), poses_of(model.schema, 40), {}).max;
}

// The largest distance of any value of a row of `length` numbers from what stands for it, in steps of the row.
template <class Scale>
double worst_step(const std::vector<float>& values, const std::pmr::vector<std::int16_t>& packed, std::size_t length,
                  Scale&& scale) {
  double worst = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    worst = std::max(worst, std::fabs(values[i] / double(scale(i / length)) - packed[i]));
  return worst;
}

}  // namespace

TEST_CASE("packing changes little, and less with more bits") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const FaceModel model = full_model(seed);
    const double coarse_layers = difference(model, {8, 8, 8, 0, {}, 0}),
                 coarse_basis = difference(model, {16, 16, 16, 1, {}, 0}),
                 fine = difference(model, {16, 16, 16, 0, {}, 0});
    CHECK(coarse_layers < 1e-3);
    CHECK(coarse_basis < 1e-3);
    CHECK(fine < 1e-5);
    CHECK(fine < 0.1 * coarse_layers);
    CHECK(fine < 0.1 * coarse_basis);
  }
}

TEST_CASE("rest positions come to lie on a grid a millionth of the diagonal wide") {
  const FaceModel model = full_model(1);
  const Mesh packed = pack_model(model, {}).rest;
  const double diagonal = model.rest.diagonal(), step = std::exp2(std::floor(std::log2(diagonal)) - 20);
  double worst = 0;
  for (std::size_t i = 0; i < packed.points.size(); ++i) {
    worst = std::max(worst, std::fabs(double(packed.points[i]) - model.rest.points[i]));
    CHECK(std::fmod(packed.points[i], step) == 0);
  }
  CHECK(worst <= 0.51 * step);
  CHECK(worst < 0x1p-21 * diagonal);
  CHECK(worst > 0);
  CHECK(packed.polygon_corners == model.rest.polygon_corners);
}

TEST_CASE("rest positions are rounded by an eighth of a coarser basis at most, and never by much") {
  const FaceModel model = full_model(1);
  const double diagonal = model.rest.diagonal();
  const auto worst_with = [&](double basis_step) {
    const Mesh packed = pack_model(model, {8, 8, 8, 1e-5, {}, 0, basis_step}).rest;
    double worst = 0;
    for (std::size_t i = 0; i < packed.points.size(); ++i)
      worst = std::max(worst, std::fabs(double(packed.points[i]) - model.rest.points[i]));
    return worst / diagonal;
  };
  CHECK(worst_with(2e-5) <= 2e-5 / 8);
  CHECK(worst_with(2e-5) > 2e-5 / 40);
  CHECK(worst_with(1e-2) <= 0x1p-17);
}

TEST_CASE("numbers of driven joints have finer steps than positions, and smaller ones stay") {
  FaceModel model;
  model.schema.controls.push_back({"open", -1, 1, 0, ""});
  model.rest.points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0};
  model.rest.carrier_vertices = 1;
  model.rest.driven = {{{"jaw", no_joint, joint_rotation, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}}, {1, 1, 1}, {}};
  model.rest.driven.skin = {1, {0, 0, 0}, {1, 1, 1}};
  model.network.features = {{Feature::Kind::identity, 0, 1, 0, 0, 0, 0}};
  model.network.direct = {0};
  const std::vector<float> values = {0.02f, 0, 0, 0, 0.02f, 0, 0, 0, 0.02f};
  model.basis = {12, 1, {{0, 9, {0}, values}, {9, 3, {0}, {0, 0.02f, 0}}}, {}};
  PackOptions options;
  options.step = 0.01;
  const PackedModel packed = pack_model(model, options);
  const double step = 0.01 * model.rest.diagonal();
  CHECK(packed.row_blocks[0].columns.at(0).scale == doctest::Approx(step).epsilon(0.01));
  CHECK(packed.row_blocks[1].columns.at(0).scale == doctest::Approx(step / 32).epsilon(0.01));
  options.drop = 0.05;
  const PackedModel fewer = pack_model(model, options);
  CHECK(fewer.row_blocks[0].columns.empty());
  CHECK(fewer.row_blocks[1].columns.size() == 1);
}

TEST_CASE("weights are rounded to the nearest step of their row") {
  const FaceModel model = full_model(1);
  for (const int bits : {2, 6, 8, 16}) {
    const PackedModel packed = pack_model(model, {bits, bits, bits, 1e-5, {}, 0});
    for (std::size_t r = 0; r < 2; ++r)
      for (std::size_t l = 0; l < 3; ++l) {
        const DenseLayer& layer = model.network.regions[r].layers[l];
        const PackedLayer& whole = packed.regions[r].layers[l];
        CHECK(whole.wide == (bits == 16));
        for (std::size_t o = 0; o < layer.outputs; ++o)  // in few bits
          CHECK(std::fabs(whole.bias[o] - layer.bias[o]) <=
                (bits == 16 ? 0x1p-16f : 0x1p-8f) * std::fabs(layer.bias[o]));
        CHECK(whole.activation == layer.activation);
        CHECK(whole.skip == layer.skip);
        CHECK(worst_step(layer.weights, whole.weights, layer.inputs, [&](std::size_t o) { return whole.scales[o]; }) <
              0.501 + 0.01 * (bits == 16));
        for (std::size_t o = 0; o < layer.outputs; ++o) {
          const auto row = whole.weights.begin() + o * layer.inputs;
          const auto [low, high] = std::minmax_element(row, row + layer.inputs);
          const int most = bits == 16 ? largest_wide : (1 << (bits - 1)) - 1;
          CHECK(std::max<int>(-*low, *high) <= most);
          CHECK(std::max<int>(-*low, *high) >= most * 127 / 128 - 1);  // scales are in few bits, too
        }
      }
  }
  for (const int bits : {1, 9, 12, 17}) CHECK_THROWS_AS(pack_model(model, {8, bits, 8, 1e-5, {}, 0}), Error);
}

TEST_CASE("first, hidden and last layers have the bits asked for") {
  const PackedModel packed = pack_model(full_model(1), {16, 8, 16, 1e-5, {}, 0});
  CHECK(packed.regions[0].layers[0].wide);
  CHECK(!packed.regions[0].layers[1].wide);
  CHECK(packed.regions[0].layers[2].wide);
}

TEST_CASE("columns are wide where rounding would move a vertex too far, and what moves nothing is dropped") {
  FaceModel model = tiny_model();
  const double diagonal = model.rest.diagonal();
  const auto rows = static_cast<std::uint32_t>(model.rest.points.size());
  // Columns whose largest value is 254, 2.54 and .0254 tolerances, for coefficients of size 1.
  std::vector<float> dense(std::size_t(5) * rows, 0.0f);
  const float sizes[] = {2540, 254, 25.4f, 2.54f, 0};
  for (std::uint32_t column = 0; column < 5; ++column)
    for (std::uint32_t row = 0; row < rows; ++row)
      dense[column * rows + row] = float(1e-5 * diagonal) * sizes[column] * std::cos(float(row) + 1) * 0.9f;
  model.basis = make_basis(rows, 5, dense);
  PackedModel packed = pack_model(model, {});
  REQUIRE(packed.row_blocks[0].columns.size() == 4);  // the last is 0 everywhere
  CHECK(packed.row_blocks[0].columns[0].wide);
  CHECK(!packed.row_blocks[0].columns[1].wide);
  CHECK(!packed.row_blocks[0].columns[3].wide);

  packed = pack_model(model, {8, 8, 8, 1e-5, {0.01f, 10, 1000, 0, 1}, 0});
  CHECK(!packed.row_blocks[0].columns[0].wide);
  CHECK(packed.row_blocks[0].columns[1].wide);
  CHECK(packed.row_blocks[0].columns[2].wide);
  CHECK(!packed.row_blocks[0].columns[3].wide);  // a coefficient that is always 0

  packed = pack_model(model, {8, 8, 8, 1e-5, {}, 3e-5});
  REQUIRE(packed.row_blocks[0].columns.size() == 3);
  CHECK(packed.row_blocks[0].columns[2].column == 2);
  CHECK_THROWS_AS(pack_model(model, {8, 8, 8, 1e-5, {1, 1}, 0}), Error);
}

TEST_CASE("numbers next to nothing become nothing, the largest stay finite") {
  FaceModel model = full_model(1);
  DenseLayer& layer = model.network.regions[0].layers[1];
  const float sizes[] = {0, 1e-45f, 1e-38f, 1e-31f, 1e-20f, 1, 1e20f, 3.4e38f};
  for (std::size_t row = 0; row < 8; ++row)
    for (std::size_t i = 0; i < 8; ++i) layer.weights[8 * row + i] = sizes[row] * (i == 0 ? 1.0f : -0.1f * float(i));
  for (const int bits : {8, 16}) {
    const PackedLayer packed = pack_model(model, {8, bits, 8, 1e-5, {}, 0}).regions[0].layers[1];
    for (std::size_t row = 0; row < 8; ++row) {
      CHECK((packed.scales[row] == 0) == (sizes[row] < 0x1p-100f));
      const int most = bits == 8 ? largest_narrow : largest_wide;
      if (sizes[row] < 0x1p-100f)
        CHECK(packed.weights[8 * row] == 0);
      else
        CHECK(packed.weights[8 * row] >= most * 127 / 128 - 1);
      CHECK(std::isfinite(packed.scales[row]));
    }
  }
}

TEST_CASE("the float face is the rest mesh at rest and follows the order of rows") {
  FaceModel model = full_model(2);
  const std::vector<double> rest = FloatFace(model).evaluate(model.schema.rest_pose());
  for (std::size_t i = 0; i < rest.size(); ++i) CHECK(rest[i] == model.rest.points[i]);

  std::vector<float> pose = model.schema.rest_pose();
  pose[0] = 0.5f;
  const std::vector<double> weights = FloatFace(model).coefficients(pose), posed = FloatFace(model).evaluate(pose);
  std::vector<double> expected(model.rest.points.begin(), model.rest.points.end());
  for (const RowBlock& group : model.basis.row_blocks)
    for (std::size_t c = 0; c < group.columns.size(); ++c)
      for (std::uint32_t r = 0; r < group.row_count; ++r) {
        const std::uint32_t row = group.first_row + r;
        expected[3 * model.basis.order[row / 3] + row % 3] +=
            weights[group.columns[c]] * group.values[c * group.row_count + r];
      }
  for (std::size_t i = 0; i < expected.size(); ++i) CHECK(posed[i] == doctest::Approx(expected[i]).epsilon(1e-9));
}

}  // namespace test_pack_model
