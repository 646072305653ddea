// Every inconsistency of a float model is refused by name.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "base/status.h"
#include "test_models.h"

namespace fb::test_checks {
namespace {

// Breaks one property of a valid model and expects check() to name it.
void refuses(Status status, const char* part, const std::function<void(FaceModel&)>& breaking) {
  FaceModel model = tiny_model();
  breaking(model);
  try {
    check(model);
    FAIL_CHECK("accepted: " << part);
  } catch (const Error& error) {
    CHECK_MESSAGE(error.status() == status, error.what());
    CHECK_MESSAGE(std::string(error.what()).find(part) != std::string::npos, error.what());
  }
}

}  // namespace

TEST_CASE("valid models pass") {
  for (std::uint64_t seed = 1; seed < 5; ++seed) CHECK_NOTHROW(check(tiny_model(seed)));
}

TEST_CASE("controls") {
  refuses(Status::bad_data, "rig \"tiny\" has no controls", [](auto& m) { m.schema.controls.clear(); });
  refuses(Status::bad_data, "the up axis is \"x\"", [](auto& m) { m.schema.up_axis = std::string("x"); });
  refuses(Status::bad_data, "control 2 has no name", [](auto& m) { m.schema.controls[2].name.clear(); });
  refuses(Status::bad_data, "\"jaw_open\" occurs twice",
          [](auto& m) { m.schema.controls[3].name = m.schema.controls[0].name; });
  refuses(Status::not_finite, "\"lid_close\"", [](auto& m) { m.schema.controls[3].maximum = INFINITY; });
  refuses(Status::not_finite, "\"lid_close\"", [](auto& m) { m.schema.controls[3].rest = NAN; });
  refuses(Status::bad_data, "minimum 2 is not below maximum 2", [](auto& m) { m.schema.controls[3].minimum = 2; });
  refuses(Status::bad_data, "default -0.5 is outside its range 0..2",
          [](auto& m) { m.schema.controls[3].rest = -0.5f; });
}

TEST_CASE("rest mesh") {
  refuses(Status::bad_data, "0 coordinates", [](auto& m) { m.rest.points.clear(); });
  refuses(Status::bad_data, "89 coordinates", [](auto& m) { m.rest.points.pop_back(); });
  refuses(Status::not_finite, "vertex 7 is not finite", [](auto& m) { m.rest.points[3 * 7 + 1] = NAN; });
  refuses(Status::bad_data, "polygon 4 has 2 corners", [](auto& m) { m.rest.polygon_sizes[4] = 2; });
  refuses(Status::bad_data, "runs past", [](auto& m) { m.rest.polygon_corners.pop_back(); });
  refuses(Status::bad_data, "polygons use", [](auto& m) { m.rest.polygon_corners.push_back(0); });
  refuses(Status::bad_data, "polygon 1 names vertex 30 of 30", [](auto& m) { m.rest.polygon_corners[5] = 30; });
  refuses(Status::bad_data, "3 numbers are not pairs", [](auto& m) { m.rest.uvs = {0, 0, 1}; });
  refuses(Status::bad_data, "0 corners have texture coordinates where 84 should", [](auto& m) { m.rest.uvs = {0, 0}; });
  refuses(Status::bad_data, "84 corners have texture coordinates where 0 should",
          [](auto& m) { m.rest.uv_corners.resize(84); });
  refuses(Status::not_finite, "texture coordinate 1 is not finite", [](auto& m) {
    m.rest.uvs = {0, 0, 1, INFINITY};
    m.rest.uv_corners.resize(84);
  });
  refuses(Status::bad_data, "corner 83 names texture coordinate 2 of 2", [](auto& m) {
    m.rest.uvs = {0, 0, 1, 1};
    m.rest.uv_corners.resize(84);
    m.rest.uv_corners[83] = 2;
  });
  refuses(Status::bad_data, "all vertices lie on one point", [](auto& m) {
    for (float& x : m.rest.points) x = 1;
  });
}

TEST_CASE("features and coefficients") {
  refuses(Status::unsupported, "feature 2 has unknown kind 9",
          [](auto& m) { m.network.features[2].kind = static_cast<Feature::Kind>(9); });
  refuses(Status::bad_data, "feature 0 names control 5 of 5", [](auto& m) { m.network.features[0].control = 5; });
  refuses(Status::not_finite, "feature 1 has scale", [](auto& m) { m.network.features[1].scale = NAN; });
  refuses(Status::not_finite, "feature 3 has scale", [](auto& m) { m.network.features[3].threshold = -1; });
  refuses(Status::not_finite, "feature 3 has scale", [](auto& m) { m.network.features[3].fall = NAN; });
  refuses(Status::bad_data, "feature 4 is made of feature 4, which does not come before it", [](auto& m) {
    m.network.features[4].kind = Feature::Kind::product;
    m.network.features[4].second = 4;
  });
  refuses(Status::bad_data, "a direct coefficient names feature 6 of 6", [](auto& m) { m.network.direct[1] = 6; });
}

TEST_CASE("regions and layers") {
  refuses(Status::bad_data, "region \"face\" names feature 6 of 6",
          [](auto& m) { m.network.regions[0].features[0] = 6; });
  refuses(Status::bad_data, "region \"face\" has no layers", [](auto& m) { m.network.regions[0].layers.clear(); });
  refuses(Status::bad_data, "layer 0 takes 6 inputs and is given 5",
          [](auto& m) { m.network.regions[0].features.pop_back(); });
  refuses(Status::bad_data, "layer 2 has no outputs", [](auto& m) { m.network.regions[0].layers[2].outputs = 0; });
  refuses(Status::bad_data, "layer 1 is 8 x 8 and has 63 weights",
          [](auto& m) { m.network.regions[0].layers[1].weights.pop_back(); });
  refuses(Status::bad_data, "64 weights, 9 biases", [](auto& m) { m.network.regions[0].layers[1].bias.push_back(0); });
  refuses(Status::bad_data, "layer 0 skips from 6 inputs to 8 outputs",
          [](auto& m) { m.network.regions[0].layers[0].skip = true; });
  refuses(Status::unsupported, "layer 0 has unknown activation 5",
          [](auto& m) { m.network.regions[0].layers[0].activation = static_cast<Activation>(5); });
  refuses(Status::not_finite, "layer 1 holds a weight that is not finite",
          [](auto& m) { m.network.regions[0].layers[1].weights[3] = INFINITY; });
  refuses(Status::not_finite, "layer 1 holds a weight that is not finite",
          [](auto& m) { m.network.regions[0].layers[1].bias[3] = NAN; });
}

TEST_CASE("basis") {
  refuses(Status::bad_data, "row block 1 begins at row", [](auto& m) { m.basis.row_blocks[1].first_row = 60; });
  refuses(Status::bad_data, "lists column 5", [](auto& m) { m.basis.row_blocks[0].columns.back() = 5; });
  refuses(Status::bad_data, "row block 0 lists column",
          [](auto& m) { std::swap(m.basis.row_blocks[0].columns[0], m.basis.row_blocks[0].columns[1]); });
  refuses(Status::bad_data, "row block 0 has 255 values", [](auto& m) { m.basis.row_blocks[0].values.pop_back(); });
  refuses(Status::not_finite, "row block 1 holds a value", [](auto& m) { m.basis.row_blocks[1].values[0] = NAN; });
  refuses(Status::bad_data, "row blocks cover 64 of 90 rows", [](auto& m) { m.basis.row_blocks.pop_back(); });
  refuses(Status::bad_data, "the order has 1 vertices for 90 rows", [](auto& m) { m.basis.order = {0}; });
  refuses(Status::bad_data, "the basis has 87 rows for 90 coordinates",
          [](auto& m) { m.basis = make_basis(87, 5, std::vector<float>(5 * 87, 1.0f)); });
  refuses(Status::bad_data, "the basis has 4 columns for 5 coefficients",
          [](auto& m) { m.basis = make_basis(90, 4, std::vector<float>(4 * 90, 1.0f)); });
}

}  // namespace fb::test_checks
