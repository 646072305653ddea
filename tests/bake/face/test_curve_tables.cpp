#include "bake/face/curve_tables.h"

#include <doctest/doctest.h>

#include <cmath>

#include "bake/analysis/activation_curve.h"
#include "bake/compress/pack_model.h"
#include "bake/recipe/bake_options.h"
#include "memory_source.h"

namespace test_curve_tables {

using namespace fb;
using namespace fb::bake;

namespace {

constexpr std::size_t side = 5, knots = 40;

// Control 0 has a shape at each of many knots, of rank 2; control 1 has one shape.
SparseBlendshapes base_of(const MemorySource& source) {
  SparseBlendshapes base;
  const auto add = [&](const Feature& feature, double a, double b) {
    SparseShape shape{static_cast<std::uint32_t>(base.features.size()), {}, {}};
    base.features.push_back(feature);
    for (std::uint32_t v = 3; v < side * side; ++v) {
      shape.vertices.push_back(v);
      for (int axis = 0; axis < 3; ++axis)
        shape.offsets.push_back(static_cast<float>(a * std::sin(v + axis) + b * std::cos(2.0 * v * axis)));
    }
    base.shapes.push_back(shape);
  };
  for (std::size_t k = 1; k <= knots; ++k) {
    const double knot = double(k) / knots;
    add(tent(source.schema().controls[0], 0, knot - 1.0 / knots, knot, knot + 1.0 / knots), std::sin(9 * knot),
        0.4 * knot);
  }
  add(side_ramp(source.schema().controls[1], 1, true), 0.3, 0.1);
  return base;
}

}  // namespace

TEST_CASE("the shapes of a control of many knots become a table of as few columns as they have directions") {
  MemorySource source(2, side, [](const float*, std::span<float>) {});
  source.add_clip("poses", ClipKind::dense, Split::train, 300, 0.8f, 1);
  const PoseSet poses = training_poses(source, Use::variant);
  const SparseBlendshapes whole = base_of(source);
  SparseBlendshapes base = whole;
  const std::vector<CurveTable> tables = take_curve_tables(base, poses, 1e-6);
  REQUIRE(tables.size() == 1);
  const CurveTable& table = tables[0];
  CHECK(base.shapes.size() == 1);
  CHECK(base.features.size() == whole.features.size());
  CHECK(table.basis.count == 2);
  CHECK(table.region.name == "control0");
  CHECK(table.region.vertices.size() == side * side - 3);
  const DenseLayer& layer = table.network.layers.at(0);
  CHECK(layer.inputs == knots);
  CHECK(layer.activation == Activation::linear);
  // Table plus base is the base before, in every pose.
  const std::vector<float> controls = poses.controls(), rest = source.schema().rest_pose();
  double worst = 0;
  for (std::size_t p = 0; p < poses.size(); ++p) {
    std::vector<float> off(3 * side * side);
    const auto pose = std::span(controls).subspan(2 * p, 2);
    whole.add(pose, rest, 1, 1, off);
    base.add(pose, rest, 1, -1, off);
    for (std::size_t k = 0; k < table.basis.count; ++k)
      for (std::size_t i = 0; i < table.basis.rows; ++i)
        off[3 * table.region.vertices[i / 3] + i % 3] -=
            table.basis.coefficients[p * table.basis.count + k] * table.basis.components[k * table.basis.rows + i];
    for (const float x : off) worst = std::max(worst, std::abs(double(x)));
  }
  CHECK(worst < 1e-4);
}

TEST_CASE("a base of few shapes a control stays as it is") {
  MemorySource source(2, side, [](const float*, std::span<float>) {});
  source.add_clip("poses", ClipKind::dense, Split::train, 30, 0.8f, 1);
  SparseBlendshapes base = base_of(source);
  base.shapes.erase(base.shapes.begin(), base.shapes.begin() + 20);
  const std::size_t shapes = base.shapes.size();
  CHECK(take_curve_tables(base, training_poses(source, Use::variant), 1e-6).empty());
  CHECK(base.shapes.size() == shapes);
}

TEST_CASE("a table is packed in 16 bits, networks in those that are asked for") {
  FaceModel model;
  MemorySource source(1, side, [](const float*, std::span<float>) {});
  model.schema = source.schema();
  model.rest = source.rest();
  model.network.features = {{Feature::Kind::identity, 0, 1}};
  const DenseLayer layer{1, 1, Activation::linear, false, {0.3f}, {0}};
  model.network.regions = {{"table", {0}, {layer}}, {"network", {0}, {layer, layer}}};
  model.basis = {3 * side * side, 2, {{0, 3 * side * side, {}, {}}}};
  PackOptions six_bits;
  six_bits.first_bits = six_bits.hidden_bits = six_bits.output_bits = 6;
  const PackedModel packed = pack_model(model, six_bits);
  CHECK(packed.regions[0].layers[0].wide);
  CHECK_FALSE(packed.regions[1].layers[0].wide);
  CHECK_FALSE(packed.regions[1].layers[1].wide);
}

}  // namespace test_curve_tables
