// What is written comes back: exactly, except the values that are stored in 16 bits.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "archive/reader.h"
#include "archive/writer.h"
#include "archive_editor.h"
#include "base/status.h"
#include "test_models.h"

namespace fb {
namespace {

// The bound of FORMAT.md on what rounding to 16 bits changes in a row, checked row by row.
void check_quantized(const std::vector<float>& before, const std::vector<float>& after, std::size_t row_length) {
  REQUIRE(before.size() == after.size());
  for (std::size_t row = 0; row < before.size(); row += row_length) {
    double largest = 0, worst = 0;
    for (std::size_t i = row; i < row + row_length; ++i) {
      largest = std::max(largest, std::fabs(double(before[i])));
      worst = std::max(worst, std::fabs(double(before[i]) - after[i]));
    }
    CHECK(worst <= std::max(largest * (1.0 / 65534 + 0x1p-23), 0x1p-100));
  }
}

void check_same(const FaceModel& a, const FaceModel& b) {
  CHECK(a.schema.name == b.schema.name);
  CHECK(a.schema.units == b.schema.units);
  CHECK(a.schema.up_axis == b.schema.up_axis);
  REQUIRE(a.schema.control_count() == b.schema.control_count());
  for (std::size_t i = 0; i < a.schema.control_count(); ++i) {
    const Control &x = a.schema.controls[i], &y = b.schema.controls[i];
    CHECK(x.name == y.name);
    CHECK(x.group == y.group);
    CHECK(same_bits({x.minimum, x.maximum, x.rest}, {y.minimum, y.maximum, y.rest}));
  }
  CHECK(same_bits(a.rest.points, b.rest.points));
  CHECK(a.rest.polygon_sizes == b.rest.polygon_sizes);
  CHECK(a.rest.polygon_corners == b.rest.polygon_corners);
  CHECK(a.provenance == b.provenance);

  REQUIRE(a.network.features.size() == b.network.features.size());
  for (std::size_t f = 0; f < a.network.features.size(); ++f) {
    const Feature &x = a.network.features[f], &y = b.network.features[f];
    CHECK(x.kind == y.kind);
    CHECK(x.control == y.control);
    CHECK(same_bits({x.scale, x.threshold}, {y.scale, y.threshold}));
  }
  CHECK(a.network.direct == b.network.direct);
  REQUIRE(a.network.regions.size() == b.network.regions.size());
  for (std::size_t r = 0; r < a.network.regions.size(); ++r) {
    const Region &x = a.network.regions[r], &y = b.network.regions[r];
    CHECK(x.name == y.name);
    CHECK(x.features == y.features);
    REQUIRE(x.layers.size() == y.layers.size());
    for (std::size_t l = 0; l < x.layers.size(); ++l) {
      CHECK(x.layers[l].inputs == y.layers[l].inputs);
      CHECK(x.layers[l].outputs == y.layers[l].outputs);
      CHECK(x.layers[l].activation == y.layers[l].activation);
      CHECK(x.layers[l].skip == y.layers[l].skip);
      CHECK(same_bits(x.layers[l].bias, y.layers[l].bias));
      check_quantized(x.layers[l].weights, y.layers[l].weights, x.layers[l].inputs);
    }
  }
  CHECK(a.basis.rows == b.basis.rows);
  CHECK(a.basis.columns == b.basis.columns);
  REQUIRE(a.basis.groups.size() == b.basis.groups.size());
  for (std::size_t g = 0; g < a.basis.groups.size(); ++g) {
    CHECK(a.basis.groups[g].first_row == b.basis.groups[g].first_row);
    CHECK(a.basis.groups[g].row_count == b.basis.groups[g].row_count);
    CHECK(a.basis.groups[g].columns == b.basis.groups[g].columns);
    check_quantized(a.basis.groups[g].values, b.basis.groups[g].values, a.basis.groups[g].row_count);
  }
}

Proof random_proof(const FaceModel& model, std::size_t poses) {
  Random random(7);
  Proof proof;
  for (std::size_t p = 0; p < poses; ++p) {
    const auto pose = random_pose(model.schema, random);
    proof.controls.insert(proof.controls.end(), pose.begin(), pose.end());
  }
  proof.vertices = {0, 7, 29};
  proof.positions = random_values(random, poses * proof.vertices.size() * 3, 10);
  return proof;
}

}  // namespace

TEST_CASE("a model comes back with all its parts") {
  FaceModel model = tiny_model();
  model.schema.units = "furlongs";
  model.schema.up_axis = std::string("z");
  model.network.regions.push_back(model.network.regions[0]);
  model.network.regions[1].name = "second \xc3\xa9";
  model.network.regions[1].features = {5, 4, 3, 2, 1, 0};
  std::vector<float> dense(8 * model.rest.points.size(), 0);
  for (std::size_t i = 0; i < dense.size(); i += 3) dense[i] = std::sin(float(i));
  model.basis = make_basis(static_cast<std::uint32_t>(model.rest.points.size()), 8, dense);
  const Proof proof = random_proof(model, 4);
  const Archive archive = read_archive(write_archive(model, proof));
  check_same(model, archive.model);
  CHECK(same_bits(archive.proof.controls, proof.controls));
  CHECK(archive.proof.vertices == proof.vertices);
  CHECK(same_bits(archive.proof.positions, proof.positions));
  CHECK(archive.format_version == archive_format_version());
  CHECK(archive.notes.empty());
  CHECK(archive.sections.size() == 7);
}

TEST_CASE("many seeds, sizes and values come back") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    check_same(tiny_model(seed), read_archive(write_archive(tiny_model(seed), {})).model);
}

TEST_CASE("values of every magnitude keep the error bound") {
  FaceModel model = tiny_model();
  DenseLayer& layer = model.network.regions[0].layers[1];
  const float sizes[] = {0, 1e-45f, 1e-38f, 1e-20f, 1, 1e20f, 1e38f, 3.4e38f};
  for (std::size_t row = 0; row < 8; ++row)
    for (std::size_t i = 0; i < 8; ++i) layer.weights[8 * row + i] = sizes[row] * (i == 0 ? 1.0f : -0.1f * i);
  const Archive archive = read_archive(write_archive(model, {}));
  check_quantized(layer.weights, archive.model.network.regions[0].layers[1].weights, 8);
}

TEST_CASE("a model without regions, provenance or proof is an archive too") {
  FaceModel model = tiny_model();
  model.network.regions.clear();
  model.network.direct = {0, 1, 2, 3, 4};
  model.provenance.clear();
  const Archive archive = read_archive(write_archive(model, {}));
  check_same(model, archive.model);
  CHECK(archive.proof.controls.empty());
  CHECK(archive.sections.size() == 5);
}

TEST_CASE("the same model gives the same bytes") {
  const FaceModel model = tiny_model();
  const Proof proof = random_proof(model, 2);
  CHECK(write_archive(model, proof) == write_archive(tiny_model(), random_proof(model, 2)));
  CHECK(write_archive(model, proof) != write_archive(tiny_model(2), proof));
}

TEST_CASE("what does not fit is refused before anything is written") {
  const FaceModel model = tiny_model();
  Proof proof = random_proof(model, 2);
  proof.positions.pop_back();
  CHECK_THROWS_WITH_AS(write_archive(model, proof), doctest::Contains("the proof has 10 control values and 17"), Error);
  proof = random_proof(model, 2);
  proof.vertices[1] = 30;
  CHECK_THROWS_WITH_AS(write_archive(model, proof), "the proof names vertex 30 of 30", Error);
  FaceModel broken = model;
  broken.basis.columns = 6;
  CHECK_THROWS_AS(write_archive(broken, {}), Error);
  broken = model;
  broken.schema.controls[0].name = std::string(70000, 'n');
  CHECK_THROWS_WITH_AS(write_archive(broken, {}), doctest::Contains("a control's name is 70000 bytes long"), Error);
  broken.schema.controls[0].name = std::string("a\0b", 3);
  CHECK_THROWS_WITH_AS(write_archive(broken, {}), "a control's name holds a zero byte", Error);
}

}  // namespace fb
