// Writes the golden archives of this format version: write_golden FOLDER fills FOLDER/accepted with valid files, most
// of a form our writer never produces, and FOLDER/rejected with files whose names begin with the status they are
// refused with. The committed files were written by this program and never change.
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "golden_arithmetic.h"
#include "golden_edits.h"

namespace fb {
using namespace archive;
using namespace bake;
namespace {

// 16-bit segments on either side of where the base of their digits doubles, up to 256.
PackedModel digit_bases() {
  PackedModel model = tiny_packed_model();
  Random random(11);
  int base = 1;
  bool above = false;
  model.row_blocks.clear();
  for (std::uint32_t first = 0; first < 90; first += 15)
    model.row_blocks.push_back(random_row_block(random, first, 15, {0, 2, 3, 4}, 0.3f));
  for (PackedRowBlock& block : model.row_blocks) {
    block.values.clear();
    for (PackedColumn& column : block.columns) {
      const int largest = std::min(largest_narrow * base + (above ? 1 : 0), largest_wide);
      column = {column.column, true, 0.3f / static_cast<float>(largest)};
      std::pmr::vector<std::int16_t> values = random_numbers(random, block.row_count, largest);
      values[0] = static_cast<std::int16_t>(above ? -largest : largest);
      block.values.insert(block.values.end(), values.begin(), values.end());
      if (above) base = base == 256 ? 1 : 2 * base;
      above = !above;
    }
  }
  return model;
}

// Row blocks of so many rows, which split vertices; some without columns; random values.
PackedModel split_model(std::uint32_t block_rows, bool polygons) {
  PackedModel model = tiny_packed_model();
  if (!polygons) model.rest.polygon_sizes.clear(), model.rest.polygon_corners.clear();
  Random random(block_rows);
  model.row_blocks.clear();
  for (std::uint32_t row = 0; row < 90; row += block_rows) {
    std::vector<std::uint32_t> columns;
    for (std::uint32_t c = 0; c < 5; ++c)
      if (random.uniform() < 0.6f) columns.push_back(c);
    model.row_blocks.push_back(random_row_block(random, row, std::min(block_rows, 90 - row), columns, 0.25f));
  }
  return model;
}

// A polygon of many corners, a vertex with more neighbours than are used, edges of three polygons, isolated vertices.
PackedModel odd_mesh() {
  PackedModel model = smallest();
  Random random(3);
  model.rest = {random_values(random, 3 * 300, 5), {}, {}};
  Mesh& mesh = model.rest;
  const auto add = [&](std::vector<std::uint32_t> corners) {
    mesh.polygon_sizes.push_back(static_cast<std::uint32_t>(corners.size()));
    mesh.polygon_corners.insert(mesh.polygon_corners.end(), corners.begin(), corners.end());
  };
  std::vector<std::uint32_t> ring;
  for (std::uint32_t v = 50; v < 250; ++v) ring.push_back(v);
  add(ring);
  for (std::uint32_t v = 51; v + 1 < 90; ++v) add({0, v, v + 1});
  add({1, 2, 3});
  add({2, 1, 4});
  add({1, 2, 5});
  add({6, 6, 7});
  add({8, 9, 10, 11, 8, 12});
  model.features = {{Feature::Kind::identity, 0, 1, 0}};
  model.direct = {0};
  model.columns = 1;
  model.row_blocks = {random_row_block(random, 0, 900, {0}, 1)};
  for (std::size_t i = 0; i < 900; ++i) model.row_blocks[0].values[i] = static_cast<std::int16_t>(i % 100) - 50;
  return model;
}

// A surface with everything that Edgebreaker and polygons along triangles have rules for; on a grid or not.
PackedModel odd_model(float grid_step) {
  PackedModel model = smallest();
  model.rest = odd_surface(12, 9);
  if (grid_step > 0)
    for (float& x : model.rest.points) x = std::round(x / grid_step) * grid_step;
  const auto rows = static_cast<std::uint32_t>(model.rest.points.size());
  model.features = {{Feature::Kind::identity, 0, 1, 0}};
  model.direct = {0};
  model.columns = 1;
  model.row_blocks = {{0, rows, {{0, false, 0.01f}}, std::pmr::vector<std::int16_t>(rows, 3)}};
  return model;
}

// Sums that overflow in every pose but the rest pose.
PackedModel overflowing() {
  PackedModel model = tiny_packed_model();
  for (PackedLayer& layer : model.regions[0].layers)
    for (float& scale : layer.scales) scale *= 1e30f;
  for (PackedLayer& layer : model.regions[0].layers)
    for (float& bias : layer.bias) bias = 0;
  return model;
}

// The same with a last layer of tanh, which gets infinities, and in its first row infinity times 0.
PackedModel overflowing_tanh() {
  PackedModel model = overflowing();
  PackedLayer& last = model.regions[0].layers.back();
  last.activation = Activation::tanh;
  for (float& scale : last.scales) scale = 1e38f;
  std::fill_n(last.weights.begin(), last.inputs, std::int16_t(0));
  return model;
}

PackedModel long_names() {
  PackedModel model = tiny_packed_model();
  model.schema.name = std::string(65535, 'n');
  model.schema.units = "";
  model.schema.controls[0].name = "\xc3\xa9" + std::string(65533, 'c');
  model.schema.controls[1].group = std::string(65535, 'g');
  return model;
}

// As many levels as there may be, each with all vertices, without polygons and coefficients.
PackedModel levels_of_points() {
  PackedModel model = smallest();
  DetailLevel level;
  level.vertices = 2;
  model.levels.assign(15, level);
  return model;
}

// A socket whose vertices are nearly on one line, about which the pose turns them: the second eigenvalue of the matrix
// of its rotation is about 2^-24 below the first, so that a frame tells how often the matrix was squared.
PackedModel nearly_collinear() {
  constexpr float offset = 0x1p-11f;
  PackedModel model = smallest();
  model.rest.points = {-1, 0, 0, 1, 0, 0, 0, offset, 0};
  model.features = {{Feature::Kind::identity, 0, 1, 0}};
  model.direct = {0};
  model.columns = 1;
  model.row_blocks = {{0, 9, {{0, false, offset}}, {0, 0, 0, 0, 0, 0, 0, -1, 1}}};
  model.character.sockets = {{"nearly", {0, 1, 2}, {1, 1, 1}, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}};
  return model;
}

void write_accepted(const std::filesystem::path& folder) {
  const auto write = [&](const char* name, const Bytes& bytes) { write_file(folder / name, bytes); };
  write("tiny.fbk", with_proof(tiny_packed_model()));
  write("manifold.fbk", with_proof(odd_mesh()));
  write("smallest.fbk", with_proof(smallest()));
  write("surface.fbk", with_proof(odd_model(0)));
  write("surface-grid.fbk", with_proof(odd_model(0x1p-10f)));
  write("surface-coarse.fbk", with_proof(odd_model(1)));
  write("regular.fbk", with_proof(regular(true)));
  write("regular-points.fbk", with_proof(regular(false)));
  write("uvs.fbk", with_proof(with_uvs(give_uvs)));
  write("uvs-by-vertex.fbk", with_proof(with_uvs(give_uvs_by_vertex)));
  write("character.fbk", with_proof(character_model()));
  write("exact-poses.fbk", with_proof(exact_model()));
  write("body.fbk", with_proof(body_model()));
  write("levels.fbk", with_proof(levelled_model()));
  write("class-tables.fbk", with_proof(two_kinds_of_columns(514)));
  write("digit-bases.fbk", with_proof(digit_bases()));
  write("arithmetic.fbk", archive_of_arithmetic());
  write("rows-1.fbk", with_proof(split_model(1, true)));
  write("rows-5.fbk", with_proof(split_model(5, true)));
  write("rows-5-points.fbk", with_proof(split_model(5, false)));
  write("overflow.fbk", with_proof(overflowing()));
  write("overflow-tanh.fbk", with_proof(overflowing_tanh()));
  write("long-names.fbk", with_proof(long_names()));
  write("levels-of-points.fbk", with_proof(levels_of_points()));
  write("long-numbers.fbk", archive_of_long_numbers());
  write("squarings.fbk", with_proof(nearly_collinear()));
  write("unproven.fbk", write_archive(tiny_packed_model(2), {}));
  write("sections-64.fbk", many_sections(max_sections));
  write("newer-minor.fbk", edited([](ArchiveEditor& archive) { archive.minor = 9; }));
  write("stored.fbk", edited([](ArchiveEditor&) {}));
  write("marks-missing.fbk", edited([](ArchiveEditor& archive) {
          for (auto& section : archive.sections) section.flags = 0;
        }));
  write("order-reversed.fbk",
        edited([](ArchiveEditor& archive) { std::reverse(archive.sections.begin(), archive.sections.end()); }));
  write("deflated.fbk", edited([](ArchiveEditor& archive) {
          for (auto& section : archive.sections) deflate_section(section);
        }));
  write("unknown-optional.fbk", edited([](ArchiveEditor& archive) {
          archive["hair"].set(text("something newer"));
          archive["hair"].codec = 77;
          std::rotate(archive.sections.begin(), archive.sections.end() - 1, archive.sections.end());
          archive["org.example.hair_0123456789abcde"].set({});
        }));
}

// Of version 2.1.
void write_accepted_joints(const std::filesystem::path& folder) {
  const auto write = [&](const char* name, const Bytes& bytes) { write_file(folder / name, bytes); };
  write("driven.fbk", with_proof(driven_model()));
  write("driven-exact-levels.fbk", with_proof(whole_model()));
  write("driven-deep.fbk", with_proof(deep_chain(256)));
  write("driven-rotations.fbk", with_proof(many_rotations()));
  PackedModel split = split_model(5, true);
  split.rest.driven.joints = {{"arm", no_joint, joint_rotation, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}}};
  split.rest.driven.scales = {0.5f, 0.5f, 0.5f};
  split.rest.driven.skin = {1, std::vector<std::uint16_t>(30), std::vector<float>(30, 1)};
  split.rest.carrier_vertices = 1;
  split.rest.points.insert(split.rest.points.end(), 3, 0.0f);
  split.order.push_back(30);
  Random random(9);
  split.row_blocks.push_back(random_row_block(random, 90, 3, {0, 2, 4}, 0.5f));
  write("driven-split-rows.fbk", with_proof(split));
}

void write_rejected(const std::filesystem::path& folder) {
  const RejectedWriter out(folder);
  write_rejected_containers(out);
  write_rejected_sections(out);
  write_rejected_geometry(out);
  write_rejected_draco(out);
  write_rejected_characters(out);
  write_rejected_errors(out);
  write_rejected_exact_poses(out);
  write_rejected_joints(out);
  write_rejected_bodies(out);
  write_rejected_levels(out);
  write_rejected_behaviour(out);
  write_rejected_texts_and_proofs(out);
}

}  // namespace
}  // namespace fb

int main(int count, char** arguments) {
  if (count != 2) {
    std::fputs("usage: write_golden FOLDER\n", stderr);
    return 2;
  }
  const std::filesystem::path folder = arguments[1];
  fb::make_folder(folder / "accepted");
  fb::make_folder(folder / "rejected");
  fb::write_accepted(folder / "accepted");
  fb::write_accepted_joints(folder / "accepted");
  fb::write_rejected(folder / "rejected");
}
