// Reading restores what was written, bit for bit.
#include <doctest/doctest.h>

#include <algorithm>

#include "archive/reader.h"
#include "archive/writer.h"
#include "archive_editor.h"
#include "base/status.h"
#include "test_models.h"

namespace fb::test_round_trip {
using namespace archive;
namespace {

void check_same(const PackedModel& a, const PackedModel& b) {
  CHECK(a.schema.name == b.schema.name);
  CHECK(a.schema.units == b.schema.units);
  CHECK(a.schema.up_axis == b.schema.up_axis);
  REQUIRE(a.schema.control_count() == b.schema.control_count());
  for (std::size_t i = 0; i < a.schema.control_count(); ++i) {
    const Control &x = a.schema.controls[i], &y = b.schema.controls[i];
    CHECK(x.name == y.name);
    CHECK(x.group == y.group);
    CHECK(x.labels == y.labels);
    CHECK(same_bits({x.minimum, x.maximum, x.rest}, {y.minimum, y.maximum, y.rest}));
  }
  CHECK(same_bits(a.rest.points, b.rest.points));
  CHECK(a.rest.polygon_sizes == b.rest.polygon_sizes);
  CHECK(a.rest.polygon_corners == b.rest.polygon_corners);
  CHECK(a.rest.uvs == b.rest.uvs);
  CHECK(a.rest.uv_corners == b.rest.uv_corners);
  CHECK(a.rest.parts == b.rest.parts);
  CHECK(a.character == b.character);
  CHECK(a.exact == b.exact);
  CHECK(a.provenance == b.provenance);

  REQUIRE(a.features.size() == b.features.size());
  for (std::size_t f = 0; f < a.features.size(); ++f) {
    const Feature &x = a.features[f], &y = b.features[f];
    CHECK(x.kind == y.kind);
    if (x.of_features()) {
      CHECK(x.first == y.first);
      CHECK(x.second == y.second);
    } else {
      CHECK(x.control == y.control);
      CHECK(same_bits({x.scale, x.threshold, x.fall}, {y.scale, y.threshold, y.fall}));
    }
  }
  CHECK(a.direct == b.direct);
  REQUIRE(a.regions.size() == b.regions.size());
  for (std::size_t r = 0; r < a.regions.size(); ++r) {
    const PackedRegion &x = a.regions[r], &y = b.regions[r];
    CHECK(x.name == y.name);
    CHECK(x.features == y.features);
    CHECK(x.gate.features == y.gate.features);
    CHECK(x.gate.slope == y.gate.slope);
    REQUIRE(x.layers.size() == y.layers.size());
    for (std::size_t l = 0; l < x.layers.size(); ++l) {
      CHECK(x.layers[l].inputs == y.layers[l].inputs);
      CHECK(x.layers[l].outputs == y.layers[l].outputs);
      CHECK(x.layers[l].activation == y.layers[l].activation);
      CHECK(x.layers[l].skip == y.layers[l].skip);
      CHECK(x.layers[l].wide == y.layers[l].wide);
      CHECK(x.layers[l].weights == y.layers[l].weights);
      CHECK(same_bits(x.layers[l].scales, y.layers[l].scales));
      CHECK(same_bits(x.layers[l].bias, y.layers[l].bias));
    }
  }
  CHECK(a.columns == b.columns);
  CHECK(a.order == b.order);
  REQUIRE(a.row_blocks.size() == b.row_blocks.size());
  for (std::size_t g = 0; g < a.row_blocks.size(); ++g) {
    const PackedRowBlock &x = a.row_blocks[g], &y = b.row_blocks[g];
    CHECK(x.first_row == y.first_row);
    CHECK(x.row_count == y.row_count);
    CHECK(x.values == y.values);
    REQUIRE(x.columns.size() == y.columns.size());
    for (std::size_t c = 0; c < x.columns.size(); ++c) {
      CHECK(x.columns[c].column == y.columns[c].column);
      CHECK(x.columns[c].wide == y.columns[c].wide);
      CHECK(same_bits({x.columns[c].scale}, {y.columns[c].scale}));
    }
  }
}

Proof random_proof(const PackedModel& model, std::size_t poses) {
  Random random(7);
  Proof proof;
  for (std::size_t p = 0; p < poses; ++p) {
    const auto pose = random_pose(model.schema, random);
    proof.controls.insert(proof.controls.end(), pose.begin(), pose.end());
  }
  proof.vertices = {0, 7, 29};
  proof.positions = random_values(random, poses * proof.vertices.size() * 3, 10);
  for (std::size_t p = 0; p < poses; ++p) proof.hashes.push_back(random.next());
  return proof;
}

}  // namespace

TEST_CASE("a model is restored with all its parts") {
  PackedModel model = tiny_packed_model();
  model.schema.units = "furlongs";
  model.schema.up_axis = std::string("z");
  model.regions.push_back(model.regions[0]);
  model.regions[2].name = "third \xc3\xa9";
  model.regions[2].features = {5, 4, 3, 2, 1, 0};
  model.columns += 2;
  const Proof proof = random_proof(model, 4);
  const Archive archive = read_archive(write_archive(model, proof, {"no rights \xc3\xa9", "{}"}));
  check_same(model, archive.model);
  CHECK(archive.text.licence == "no rights \xc3\xa9");
  CHECK(archive.text.certificate == "{}");
  CHECK(archive.proof.hashes == proof.hashes);
  CHECK(same_bits(archive.proof.controls, proof.controls));
  CHECK(archive.proof.vertices == proof.vertices);
  CHECK(same_bits(archive.proof.positions, proof.positions));
  CHECK(archive.format_version == 2000);
  CHECK(archive.notes.empty());
  CHECK(archive.sections.size() == 11);
}

TEST_CASE("many seeds, sizes and values are restored") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed)
    for (const PackedModel& model :
         {tiny_packed_model(seed), character_model(seed), exact_model(seed), levelled_model(seed)})
      check_same(model, read_archive(write_archive(model, {})).model);
}

TEST_CASE("the limits of all ranges are restored") {
  PackedModel model = tiny_packed_model();
  PackedLayer &wide = model.regions[0].layers[0], &narrow = model.regions[0].layers[1];
  REQUIRE(wide.wide);
  REQUIRE(!narrow.wide);
  std::copy_n(std::begin({32512, -32512, 0, -1, 255, -256}), 6, wide.weights.begin());
  std::copy_n(std::begin({127, -127, 0, -1}), 4, narrow.weights.begin());
  const float odd[] = {0, -0.0f, 1e-45f, -1e-38f, 3.4e38f, -3.4e38f, 1};
  std::copy(std::begin(odd), std::end(odd), wide.scales.begin());
  std::copy(std::begin(odd), std::end(odd), wide.bias.begin());
  check_same(model, read_archive(write_archive(model, {})).model);
}

TEST_CASE("parts are read alone") {
  const PackedModel model = tiny_packed_model();
  const Bytes bytes = write_archive(model, random_proof(model, 2), {"mine", "{}"});
  const Archive definition = read_archive(bytes, {}, Parts::definition);
  CHECK(definition.model.schema.controls[2].name == "brow_raise");
  CHECK(definition.vertices == 30);
  CHECK(definition.model.rest.points.empty());
  CHECK(definition.model.rest.polygon_sizes.empty());
  CHECK(definition.model.features.empty());
  CHECK(definition.model.provenance.empty());
  const Archive mesh = read_archive(bytes, {}, Parts::mesh);
  CHECK(same_bits(mesh.model.rest.points, model.rest.points));
  CHECK(mesh.model.row_blocks.empty());
  const Archive behaviour = read_archive(bytes, {}, Parts::behaviour);
  CHECK(behaviour.model.rest.points.empty());
  REQUIRE(behaviour.model.row_blocks.size() == 2);
  CHECK(behaviour.model.row_blocks[1].values == model.row_blocks[1].values);
  CHECK(behaviour.model.regions[0].layers[0].weights == model.regions[0].layers[0].weights);
  const Archive text = read_archive(bytes, {}, Parts::text | Parts::proof);
  CHECK(text.text.licence == "mine");
  CHECK(text.model.provenance == model.provenance);
  CHECK(text.proof.hashes.size() == 2);
  CHECK(text.model.regions.empty());
}

// Values that neighbours predict badly, row blocks that split vertices, columns in few row blocks, no polygons at all.
TEST_CASE("bases of every kind are restored") {
  for (const std::uint32_t block_rows : {1u, 2u, 5u, 64u, 100u, 270u})
    for (const bool polygons : {true, false})
      for (const int reach : {0, 1, 2, 127, 32512}) {
        Random random(block_rows + static_cast<std::uint64_t>(reach));
        PackedModel model = tiny_packed_model();
        model.rest = grid_mesh(10, 9);
        if (!polygons) model.rest.polygon_sizes.clear(), model.rest.polygon_corners.clear();
        model.order.clear();
        model.row_blocks.clear();
        for (std::uint32_t v = 0; v < 90; ++v) model.order.push_back((v * 37 + 5) % 90);
        for (std::uint32_t row = 0; row < 270; row += block_rows) {
          PackedRowBlock& block = model.row_blocks.emplace_back();
          block.first_row = row;
          block.row_count = std::min(block_rows, 270 - row);
          for (std::uint32_t c = 0; c < 5; ++c) {
            if (random.uniform() < 0.3f) continue;
            block.columns.push_back({c, reach > 127, random.uniform() < 0.5f ? 0.25f : random.uniform()});
            for (std::uint32_t r = 0; r < block.row_count; ++r)
              block.values.push_back(static_cast<std::int16_t>(
                  static_cast<int>(random.below(static_cast<std::uint32_t>(2 * reach + 1))) - reach));
          }
        }
        check_same(model, read_archive(write_archive(model, {})).model);
      }
}

TEST_CASE("smooth columns take far fewer bytes than noise") {
  const auto bytes_of = [](bool smooth) {
    PackedModel model = tiny_packed_model();
    model.rest = grid_mesh(40, 40);
    model.order.clear();
    Random random(1);
    PackedRowBlock block{0, 4800, {}, {}};
    for (std::uint32_t c = 0; c < 5; ++c) {
      block.columns.push_back({c, false, 1});
      for (std::uint32_t v = 0; v < 1600; ++v)
        for (std::uint32_t axis = 0; axis < 3; ++axis)
          block.values.push_back(static_cast<std::int16_t>(smooth ? int(v % 40 + 2 * (v / 40) + axis * c) - 60
                                                                  : int(random.below(121)) - 60));
    }
    model.row_blocks = {block};
    for (const SectionInfo& section : read_archive(write_archive(model, {})).sections)
      if (section.name == "basis-values") return section.stored_bytes;
    return std::uint64_t(0);
  };
  CHECK(bytes_of(false) > 20000);
  CHECK(bytes_of(true) < 2000);
}

TEST_CASE("a model without regions, provenance or proof is an archive too") {
  PackedModel model = tiny_packed_model();
  model.regions.clear();
  model.direct = {0, 1, 2, 3, 4};
  model.provenance.clear();
  const Archive archive = read_archive(write_archive(model, {}));
  check_same(model, archive.model);
  CHECK(archive.proof.controls.empty());
  CHECK(archive.sections.size() == 7);
}

TEST_CASE("the same model gives the same bytes") {
  const PackedModel model = tiny_packed_model();
  const Proof proof = random_proof(model, 2);
  CHECK(write_archive(model, proof) == write_archive(tiny_packed_model(), random_proof(model, 2)));
  CHECK(write_archive(model, proof) != write_archive(tiny_packed_model(2), proof));
}

TEST_CASE("inconsistent models and proofs are refused") {
  const PackedModel model = tiny_packed_model();
  Proof proof = random_proof(model, 2);
  proof.positions.pop_back();
  CHECK_THROWS_WITH_AS(write_archive(model, proof), doctest::Contains("10 control values and 17"), Error);
  proof = random_proof(model, 2);
  proof.vertices[1] = 30;
  CHECK_THROWS_WITH_AS(write_archive(model, proof), "the proof names vertex 30 of 30", Error);
  PackedModel broken = model;
  broken.columns = 6;
  CHECK_THROWS_AS(write_archive(broken, {}), Error);
  broken = model;
  broken.schema.controls[0].name = std::string(70000, 'n');
  CHECK_THROWS_WITH_AS(write_archive(broken, {}), doctest::Contains("a control's name is 70000 bytes long"), Error);
  broken.schema.controls[0].name = std::string("a\0b", 3);
  CHECK_THROWS_WITH_AS(write_archive(broken, {}), "a control's name holds a zero byte", Error);
}

}  // namespace fb::test_round_trip
