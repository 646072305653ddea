#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

#include "bake/face/assemble_basis.h"
#include "bake/face/face_recipe.h"
#include "bake/face/network_inputs.h"
#include "bake/face/network_sizes.h"
#include "bake/rig/rig_evaluator.h"
#include "toy_faces.h"

namespace test_face_recipe {

using namespace fb;
using namespace fb::bake;

TEST_CASE("networks share the parameters, wider where the expected error is larger") {
  const std::vector<NetworkDemand> demands = {{40, 60, 1.0}, {10, 12, 1e-2}, {10, 12, 1e-8}};
  for (const std::size_t parameters : {60'000u, 200'000u, 600'000u}) {
    const std::vector<std::uint32_t> widths = network_widths(demands, 4, 512, parameters);
    std::size_t total = 0;
    for (std::size_t r = 0; r < demands.size(); ++r) {
      CHECK(widths[r] % 16 == 0);
      CHECK(widths[r] >= 32);
      total += network_parameters(demands[r], 4, widths[r]);
    }
    CHECK(total <= parameters);
    CHECK(total > parameters / 2);
    CHECK(widths[0] > widths[1]);
    CHECK(widths[1] >= widths[2]);
  }
  CHECK(network_parameters({3, 2, 1}, 2, 5) == 3 * 5 + 5 + 5 * 5 + 5 + 5 * 2 + 2);
  CHECK(network_widths(demands, 4, 512, 1) == std::vector<std::uint32_t>{32, 32, 32});
}

TEST_CASE("the basis of a face holds the shapes and components of each vertex, and no zero columns") {
  SparseBlendshapes base;
  base.features = {{Feature::Kind::identity, 0, 1, 0}};
  base.shapes = {{0, {1, 40}, {1, 2, 3, 4, 5, 6}}};
  const std::vector<FaceRegion> regions = {{"left", {0, 1}, {1, 1}, {0}, 1}};
  LocalBasis local;
  local.rows = 6;
  local.count = 1;
  local.components = {10, 11, 12, 13, 14, 15};
  const Basis basis = assemble_basis(50, base, regions, std::vector{local});
  check(basis);
  CHECK(basis.rows == 150);
  CHECK(basis.columns == 2);
  std::vector<float> moved(150, 0.0f);
  for (const RowBlock& group : basis.row_blocks)
    for (std::size_t c = 0; c < group.columns.size(); ++c)
      for (std::size_t row = 0; row < group.row_count; ++row)
        moved[group.first_row + row] += group.values[c * group.row_count + row] * (group.columns[c] == 0 ? 1 : 100);
  CHECK(moved[0] == 1000);
  CHECK(moved[3] == 1301);
  CHECK(moved[5] == 1503);
  CHECK(moved[120] == 4);
  CHECK(std::accumulate(moved.begin(), moved.end(), 0.0f) == 21 + 100 * (10 + 11 + 12 + 13 + 14 + 15));
  CHECK(basis.value_count() ==
        2 * 63 + 63);  // both columns in the first block of 21 vertices, the shape in that of vertex 40
}

TEST_CASE("a region's inputs are its controls and the strongest features of their correctives, about as many") {
  RigAnalysis analysis;
  for (std::uint32_t c = 0; c < 4; ++c) analysis.base.features.push_back({Feature::Kind::identity, c});
  const auto add_corrective = [&](std::uint32_t a, std::uint32_t b) {
    Feature product{Feature::Kind::product};
    product.first = a;
    product.second = b;
    const auto feature = static_cast<std::uint32_t>(analysis.base.features.size());
    analysis.base.features.push_back(product);
    analysis.correctives.push_back({{a, b}, 1, {feature}});
    return feature;
  };
  const std::uint32_t first = add_corrective(0, 1), elsewhere = add_corrective(2, 3), second = add_corrective(1, 2);
  const std::uint32_t third = add_corrective(0, 2), weakest = add_corrective(0, 1);
  RigSchema schema;
  for (const char* name : {"a", "b", "c", "d"}) {
    Control control;
    control.name = name;
    control.minimum = 0;
    control.maximum = 1;
    schema.controls.push_back(control);
  }
  const FaceRegion region{"lips", {0}, {1}, {0, 1, 2}, 1};
  const RegionInputs inputs = region_inputs(analysis, schema, std::vector{region}, true);
  REQUIRE(inputs.of_region.size() == 1);
  const std::vector<std::uint32_t>& features = inputs.of_region[0];
  CHECK(features.size() == 6);
  for (const std::uint32_t feature : {first, second, third}) CHECK(std::ranges::count(features, feature) == 1);
  for (const std::uint32_t feature : {elsewhere, weakest}) CHECK(std::ranges::count(features, feature) == 0);
  CHECK(inputs.gates[0].features.size() == 3);
}

TEST_CASE("inputs count by how far their controls move the region, several by the least") {
  const std::vector<Feature> features = {{Feature::Kind::identity, 1},
                                         {Feature::Kind::identity, 4},
                                         {Feature::Kind::product, 0, 1, 0, 0, 0, 1},
                                         {Feature::Kind::identity, 2}};
  FaceRegion region;
  region.controls = {1, 2, 4};
  region.motion = {1e-2f, 1e-2f, 1e-4f};
  const std::vector<std::uint32_t> all = {0, 1, 2, 3};
  const std::vector<float> scales = input_scales(features, all, region);
  REQUIRE(scales.size() == 4);
  CHECK(scales[0] == scales[3]);
  CHECK(scales[1] == scales[2]);
  CHECK(scales[1] / scales[0] == doctest::Approx(1e-3).epsilon(1e-4));
  double squares = 0;
  for (const float scale : scales) squares += double(scale) * scale;
  CHECK(squares == doctest::Approx(4));
}

TEST_CASE("unused features are removed, and indices of the others are updated") {
  Network network;
  for (std::uint32_t c = 0; c < 4; ++c) network.features.push_back({Feature::Kind::identity, c});
  Feature product{Feature::Kind::product};
  product.first = 1;
  product.second = 3;
  network.features.push_back(product);
  product.first = 0;
  network.features.push_back(product);
  network.direct = {4};
  Region region;
  region.features = {2};
  region.gate.features = {2, 3};
  network.regions.push_back(region);
  keep_live_features(network);
  REQUIRE(network.features.size() == 4);
  CHECK(network.direct == std::vector<std::uint32_t>{3});
  CHECK(network.features[network.features[3].first].control == 1);
  CHECK(network.features[network.features[3].second].control == 3);
  CHECK(network.features[network.regions[0].features[0]].control == 2);
  CHECK(network.features[network.regions[0].gate.features[1]].control == 3);
}

TEST_CASE("correctives are left to networks only where something else needs a network") {
  const auto both_formula = [](const float* controls, std::span<float> points) {
    curved_formula(controls, points);
    points[0] += std::sin(5 * controls[0] * controls[3]);
  };
  for (const bool needed : {false, true}) {
    CAPTURE(needed);
    MemorySource source = needed ? face_of(both_formula, true) : face_of(curved_formula, true);
    source.add_clip("dense", ClipKind::dense, Split::train, 400, 0.6f, 1);
    RigEvaluator rig(source);
    const WorkFolder folder;
    BakeOptions options;
    options.epochs = 1;
    options.work = folder.path;
    std::filesystem::create_directories(options.work);
    FaceRecipe recipe = compact_recipe();
    recipe.corrective_bytes = 1;
    const TrainedFace face =
        train_face(recipe, {training_poses(source, Use::variant), options.seed}, &rig, options, silent_progress());
    CHECK(face.model.network.regions.empty() == !needed);
    if (!needed) CHECK(face.rms_error < 1e-5);
  }
}

}  // namespace test_face_recipe
