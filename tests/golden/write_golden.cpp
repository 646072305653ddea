// Writes the golden archives of this format version: write_golden FOLDER fills FOLDER/accepted with valid files, most
// of a form our writer never produces, and FOLDER/rejected with files whose names begin with the status they are
// refused with. The committed files were written by this program and never change.
#include <zlib.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>

#include "archive/archive_editor.h"
#include "archive/writer.h"
#include "bake/measure/verify.h"
#include "base/file.h"
#include "golden_arithmetic.h"
#include "test_models.h"

namespace fb {
using namespace archive;
using namespace bake;
namespace {

using Edit = std::function<void(ArchiveEditor&)>;

Bytes text(const std::string& s) {
  const auto bytes = std::as_bytes(std::span(s));
  return {bytes.begin(), bytes.end()};
}

Bytes with_proof(const PackedModel& model) {
  return write_archive(model, make_proof(model, 1), {"Made for tests; no rights reserved.", "{\"dependency\": null}"});
}

Bytes edited(const Edit& edit, const PackedModel& model = tiny_packed_model()) {
  ArchiveEditor archive(with_proof(model));
  edit(archive);
  return archive.bytes();
}

Bytes changed(const char* section, const std::function<void(Bytes&)>& change,
              const PackedModel& model = tiny_packed_model()) {
  return edited(
      [&](ArchiveEditor& archive) {
        Bytes contents = archive[section].stored;
        change(contents);
        archive[section].set(contents);
      },
      model);
}

void deflate_section(ArchiveEditor::Section& section) {
  Bytes packed(compressBound(section.stored.size()));
  uLongf size = packed.size();
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(section.stored.data()),
            section.stored.size(), 1);
  packed.resize(size);
  section.codec = 1;
  section.stored = packed;
}

// The smallest valid model: two vertices and one control that moves nothing.
PackedModel smallest() {
  PackedModel model;
  model.schema.controls = {{"c", 0, 1, 0, ""}};
  model.rest.points = {0, 0, 0, 1, 0, 0};
  model.row_blocks = {{0, 6, {}, {}}};
  return model;
}

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
      std::vector<std::int16_t> values = random_numbers(random, block.row_count, largest);
      values[0] = static_cast<std::int16_t>(above ? -largest : largest);
      block.values.insert(block.values.end(), values.begin(), values.end());
      if (above) base = base == 256 ? 1 : 2 * base;
      above = !above;
    }
  }
  return model;
}

// Positions on a grid and 20 quads coded along triangles, the vertices in another order than Draco's.
PackedModel regular(bool polygons) {
  PackedModel model = tiny_packed_model();
  model.rest = grid_mesh(6, 5);
  for (float& x : model.rest.points) x = std::round(256 * x) / 256;
  for (std::size_t v = 0; v < 15; ++v)
    std::swap_ranges(&model.rest.points[3 * v], &model.rest.points[3 * v + 3], &model.rest.points[87 - 3 * v]);
  for (std::uint32_t& corner : model.rest.polygon_corners) corner = 29 - corner;
  if (!polygons) model.rest.polygon_sizes.clear(), model.rest.polygon_corners.clear();
  return model;
}

PackedModel with_uvs(void (*add_uvs)(Mesh&)) {
  PackedModel model = regular(true);
  add_uvs(model.rest);
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
  model.row_blocks = {{0, rows, {{0, false, 0.01f}}, std::vector<std::int16_t>(rows, 3)}};
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

Bytes many_sections(std::size_t count) {
  return edited([&](ArchiveEditor& archive) {
    for (int i = 0; archive.sections.size() < count; ++i) archive[format("!%d~", i)].set({});
  });
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

// Writes files into the folder of rejected archives.
class RejectedWriter {
 public:
  explicit RejectedWriter(const std::filesystem::path& folder) : folder_(folder) {}

  void write(const char* name, const Bytes& bytes) const { write_file(folder_ / name, bytes); }
  // The tiny model, or another, with the number at byte `at` of a section's contents replaced.
  template <class T>
  void patched(const char* name, const char* section, std::size_t at, T value,
               const PackedModel& model = tiny_packed_model()) const {
    write(name, changed(
                    section, [&](Bytes& b) { patch(b, at, value); }, model));
  }

 private:
  std::filesystem::path folder_;
};

void write_rejected_containers(const RejectedWriter& out) {
  const Bytes whole = with_proof(tiny_packed_model());
  Bytes other = whole;
  out.write("not_an_archive-empty.fbk", {});
  out.write("not_an_archive-text.fbk", text("#!/bin/sh\necho an archive\n"));
  other.erase(other.begin() + 4);
  out.write("corrupt-line-ends.fbk", other);
  out.write("corrupt-cut-in-header.fbk", Bytes(whole.begin(), whole.begin() + 20));
  out.write("corrupt-cut-in-table.fbk", Bytes(whole.begin(), whole.begin() + 200));
  out.write("corrupt-cut-at-end.fbk", Bytes(whole.begin(), whole.end() - 1));
  (other = whole).push_back(std::byte(0));
  out.write("corrupt-byte-more.fbk", other);
  (other = whole)[whole.size() / 2] ^= std::byte(4);
  out.write("corrupt-bit.fbk", other);
  (other = whole).back() ^= std::byte(0x80);
  out.write("corrupt-checksum.fbk", other);
  patch(other = whole, table_at(1, 40), std::uint64_t(0));
  out.write("corrupt-overlap.fbk", sealed(other));
}

void write_rejected_sections(const RejectedWriter& out) {
  out.write("unsupported-major.fbk", edited([](ArchiveEditor& archive) { archive.major = 3; }));
  out.write("unsupported-required.fbk", edited([](ArchiveEditor& archive) {
              archive["hair"].set(text("something newer"));
              archive["hair"].flags = section_required;
            }));
  out.write("unsupported-flags.fbk", edited([](ArchiveEditor& archive) { archive["proof"].flags = 2; }));
  out.write("unsupported-version-1.fbk", edited([](ArchiveEditor& archive) { archive.major = 1; }));
  out.write("unsupported-codec.fbk", edited([](ArchiveEditor& archive) { archive["network"].codec = 2; }));
  out.write("corrupt-twice.fbk",
            edited([](ArchiveEditor& archive) { archive.sections.push_back(archive.sections[0]); }));
  out.write("corrupt-missing.fbk",
            edited([](ArchiveEditor& archive) { archive.sections.erase(archive.sections.begin()); }));
  out.write("corrupt-sections-65.fbk", many_sections(max_sections + 1));
  out.write("corrupt-stream-more.fbk", edited([](ArchiveEditor& archive) {
              deflate_section(archive["basis"]);
              archive["basis"].stored.push_back(std::byte(0));
            }));
  out.write("corrupt-stream-size.fbk", edited([](ArchiveEditor& archive) {
              deflate_section(archive["basis"]);
              ++archive["basis"].raw_bytes;
            }));
  for (const char* name :
       {"definition", "polygons", "geometry", "network", "weights", "basis", "basis-values", "proof"}) {
    const std::string file = format("corrupt-%s-more.fbk", name);
    out.write(file.c_str(), changed(name, [](Bytes& b) { b.resize(b.size() + 2); }));
  }
}

void write_rejected_geometry(const RejectedWriter& out) {
  out.patched("corrupt-vertices.fbk", "definition", 19, std::uint32_t(31));
  out.write("corrupt-up-axis.fbk", changed("definition", [](Bytes& b) { b[18] = std::byte('x'); }));
  out.patched("corrupt-zero-in-name.fbk", "definition", 4, std::uint8_t(0));
  out.patched("corrupt-no-vertices.fbk", "definition", 19, std::uint32_t(0));
  out.patched("corrupt-sizes.fbk", "polygons", 4, std::uint32_t(7));
  // The tiny model's mesh of 30 vertices has 34 points, after which the Draco data begins.
  constexpr std::size_t draco = 12 + 4 * 34;
  out.patched("corrupt-points.fbk", "geometry", 0, std::uint32_t(29));
  out.patched("corrupt-point-vertex.fbk", "geometry", 12, std::uint8_t(61));
  out.patched("corrupt-draco.fbk", "geometry", draco, std::uint8_t(0));
  out.patched("corrupt-draco-points.fbk", "geometry", draco + 12, std::uint8_t(33));
  out.patched("corrupt-draco-seams.fbk", "geometry", draco + 14, std::uint8_t(1));
  out.patched("corrupt-draco-symbols.fbk", "geometry", draco + 15, std::uint8_t(1));
  out.patched("corrupt-triangles.fbk", "geometry", 4, std::uint32_t(1));
  out.patched("corrupt-grid.fbk", "geometry", 8, 0.75f);
  out.patched("corrupt-floats-on-grid.fbk", "geometry", 8, 0.5f);
  const PackedModel on_grid = regular(true);
  out.patched("corrupt-edge-index.fbk", "polygons", 8 + 4 * 20 + 7, std::uint8_t(6), on_grid);
  out.patched("corrupt-first-corner.fbk", "polygons", 8 + 4 * 20 + 20, std::uint8_t(60), on_grid);
  out.patched("corrupt-corner-missing.fbk", "polygons", 8 + 4 * 20 + 7, std::uint8_t(255), on_grid);
  out.patched("corrupt-coarse-grid.fbk", "geometry", 8, 0x1p126f, on_grid);
  out.patched("corrupt-grid-for-floats.fbk", "geometry", 8, 0.0f, on_grid);
  const PackedModel seam = with_uvs(give_uvs), by_vertex = with_uvs(give_uvs_by_vertex);
  out.patched("corrupt-no-uvs.fbk", "uvs", 0, std::uint32_t(0), seam);
  out.patched("corrupt-uvs-by-vertex.fbk", "uvs", 4, std::uint32_t(1), seam);
  out.patched("corrupt-uv-corner.fbk", "uvs", 8 + 8 * 60, std::uint8_t(200), seam);
  out.patched("corrupt-uv-deltas.fbk", "uvs", 4, std::uint32_t(0), by_vertex);
  out.patched("unsupported-uvs.fbk", "uvs", 4, std::uint32_t(2), seam);
}

void write_rejected_characters(const RejectedWriter& out) {
  const PackedModel model = character_model();
  out.write("corrupt-labels-more.fbk", changed(
                                           "labels", [](Bytes& b) { b.resize(b.size() + 2); }, model));
  // The first control's texts take 4 + 7, 4 + 4 and 4 + 7 bytes; then its partner, and 16 bytes of the second control.
  out.patched("corrupt-mirror-missing.fbk", "labels", 30, std::uint32_t(5), model);
  out.patched("corrupt-mirror-alone.fbk", "labels", 30, std::uint32_t(1), model);
  // The unit and two regions take 4 + 4 + (4 + 5 + 4) + (4 + 17 + 4) bytes, three runs 4 + 3 x 8.
  constexpr std::size_t runs = 46, error_weights = runs + 4 + 24, trained = error_weights + 10, pairs = trained + 10;
  out.patched("corrupt-error-unit.fbk", "expected-errors", 0, 0.0f, model);
  out.patched("corrupt-error-constant.fbk", "expected-errors", 17, -1.0f, model);
  out.patched("corrupt-error-runs.fbk", "expected-errors", runs + 4, std::uint32_t(8), model);
  out.patched("corrupt-error-region.fbk", "expected-errors", runs + 8, std::uint32_t(2), model);
  out.patched("corrupt-error-trained.fbk", "expected-errors", trained, std::uint8_t(201), model);
  out.patched("corrupt-error-pairs.fbk", "expected-errors", pairs + 1, std::uint8_t(128), model);
  out.patched("unproven-error.fbk", "expected-errors", error_weights, std::uint8_t(200), model);
  for (const char* name : {"meshes", "materials", "images", "sockets", "channels"}) {
    out.write(format("corrupt-no-%s.fbk", name).c_str(), changed(
                                                             name, [](Bytes& b) { b.assign(4, {}); }, model));
    out.write(format("corrupt-%s-more.fbk", name).c_str(), changed(
                                                               name, [](Bytes& b) { b.resize(b.size() + 2); }, model));
  }
  out.patched("corrupt-mesh-vertices.fbk", "meshes", 12, std::uint32_t(17), model);
  out.patched("corrupt-mesh-run.fbk", "meshes", 24, std::uint32_t(7), model);
  out.patched("corrupt-mesh-material.fbk", "meshes", 28, std::uint32_t(2), model);
  PackedModel points = model;
  points.rest.polygon_sizes.clear(), points.rest.polygon_corners.clear();
  points.rest.uvs.clear(), points.rest.uv_corners.clear();
  points.rest.parts = {{"head", 18, 0}, {"teeth", 12, 0}};
  points.character.sockets.clear();
  const auto move_vertex = [](Bytes& b) {  // to the other mesh, so that a row block has vertices of both
    patch(b, 12, std::uint32_t(17));
    patch(b, 24 + 9, std::uint32_t(13));
  };
  out.write("corrupt-mesh-rows.fbk", changed("meshes", move_vertex, points));
  out.patched("corrupt-material-factor.fbk", "materials", 12, std::uint32_t(0x7fc00000), model);
  out.patched("corrupt-material-image.fbk", "materials", 61, std::uint32_t(3), model);
  out.patched("corrupt-socket-vertex.fbk", "sockets", 16, std::uint32_t(30), model);
  out.patched("corrupt-socket-meshes.fbk", "sockets", 16, std::uint32_t(18), model);
  out.patched("corrupt-socket-weight.fbk", "sockets", 16 + 5 * 4, 0.0f, model);
  out.patched("corrupt-socket-frame.fbk", "sockets", 16 + 5 * 8, std::uint32_t(0x7f800000), model);
  out.patched("corrupt-about.fbk", "about", 3, std::uint8_t(0xff), model);
  out.patched("corrupt-about-zero.fbk", "about", 3, std::uint8_t(0), model);
  out.write("corrupt-about-long.fbk", changed(
                                          "about", [](Bytes& b) { b.resize(65537, std::byte(' ')); }, model));
  out.patched("corrupt-thumbnail.fbk", "thumbnail", 1, std::uint8_t('G'), model);
  out.patched("corrupt-thumbnail-oblong.fbk", "thumbnail", 19, std::uint8_t(2), model);
  out.write("corrupt-thumbnail-long.fbk", changed(
                                              "thumbnail", [](Bytes& b) { b.resize(65537); }, model));
  // The last number of frames, of channels, of expected errors and of "outside", of which each pose has so many.
  const std::size_t channels = model.schema.channels.size(), errors = model.expected.count();
  const auto change_behind = [&](const char* file, std::size_t numbers_after) {
    const auto change = [&](Bytes& b) {
      std::uint32_t poses = 0;
      std::memcpy(&poses, b.data(), sizeof poses);
      b[b.size() - 4 * (poses * numbers_after + 1)] ^= std::byte(1);
    };
    out.write(file, changed("proof", change, model));
  };
  change_behind("unproven-frame.fbk", channels + errors + 1);
  change_behind("unproven-channel.fbk", errors + 1);
  change_behind("unproven-expected.fbk", 1);
  change_behind("unproven-outside.fbk", 0);
  // The first channel's name takes 4 + 5 bytes, its unit 4.
  out.patched("corrupt-channel-range.fbk", "channels", 17, 1.0f, model);
  out.patched("corrupt-channel-rest.fbk", "channels", 17 + 8, 2.0f, model);
  out.patched("corrupt-channel-scale.fbk", "channels", 17 + 12, 0.0f, model);
  out.patched("unsupported-alpha-mode.fbk", "materials", 48, std::uint8_t(3), model);
  out.patched("unsupported-material-flags.fbk", "materials", 53, std::uint8_t(3), model);
  out.patched("unsupported-texture-slot.fbk", "materials", 58, std::uint8_t(5), model);
  out.patched("unsupported-texture-wrap.fbk", "materials", 60, std::uint8_t(3), model);
}

void write_rejected_exact_poses(const RejectedWriter& out) {
  const PackedModel model = exact_model();
  const char* const name = "exact-poses";
  // Names take 4 + 8 and 4 + 7 bytes, controls 5 x 4, falloff and step 4 each.
  constexpr std::size_t controls = 4 + 12, falloff = controls + 20, step = falloff + 4, second = step + 4,
                        values = second + 11 + 20 + 8;
  out.write("corrupt-no-exact.fbk", changed(
                                        name, [](Bytes& b) { b.assign(4, {}); }, model));
  out.write("corrupt-exact-more.fbk", changed(
                                          name, [](Bytes& b) { b.resize(b.size() + 2); }, model));
  out.write("corrupt-exact-names.fbk", changed(
                                           name,
                                           [&](Bytes& b) {
                                             std::copy_n(b.begin() + 4, 12, b.begin() + second);
                                             b.insert(b.begin() + second + 12, b[second + 12]);
                                           },
                                           model));
  out.patched("corrupt-exact-control.fbk", name, controls, 1.5f, model);
  out.patched("corrupt-exact-falloff.fbk", name, falloff, 0.0f, model);
  out.patched("corrupt-exact-reach.fbk", name, falloff, 0x1p-10f, model);
  out.patched("corrupt-exact-step.fbk", name, step, std::uint32_t(0x7f800000), model);
  out.patched("corrupt-exact-value.fbk", name, values + 3 * 32, std::uint8_t(0x7f), model);
  out.patched("unproven-exact.fbk", name, values + 7, std::uint8_t(0x7f), model);
}

void write_rejected_bodies(const RejectedWriter& out) {
  const PackedModel model = body_model();
  // Three joints, whose names take 4 + 4, 4 + 4 and 4 + 3 bytes; 30 counts, 30 joints of vertices.
  constexpr std::size_t head_joint = 4 + 4 + 4 + 4 + 96, skin_joints = 4 + 30, skin_weights = skin_joints + 60;
  out.patched("corrupt-joint-parent.fbk", "joints", head_joint + 8, std::uint32_t(1), model);
  out.patched("corrupt-joint-name.fbk", "joints", head_joint + 4, std::uint32_t(0x6b63656e), model);
  out.patched("corrupt-joint-frame.fbk", "joints", head_joint + 12, std::uint32_t(0x7f800000), model);
  out.patched("corrupt-skin-influences.fbk", "skin", 0, std::uint32_t(33), model);
  out.patched("corrupt-skin-count.fbk", "skin", 4, std::uint8_t(3), model);
  out.patched("corrupt-skin-joint.fbk", "skin", skin_joints, std::uint16_t(3), model);
  out.patched("corrupt-skin-weight.fbk", "skin", skin_weights + 3 * 30, std::uint8_t(0xbf), model);
  out.patched("corrupt-skin-sum.fbk", "skin", skin_weights + 3 * 30, std::uint8_t(0x3e), model);
  out.write("corrupt-skin-mesh.fbk", changed(
                                         "skin", [](Bytes& b) { std::swap(b[4], b[4 + 18]); }, model));
  out.write("corrupt-skin-more.fbk", changed(
                                         "skin", [](Bytes& b) { b.resize(b.size() + 2); }, model));
  out.write("corrupt-skin-alone.fbk", edited(
                                          [](ArchiveEditor& archive) {
                                            std::erase_if(archive.sections,
                                                          [](const auto& section) { return section.name == "joints"; });
                                          },
                                          model));
  out.write("corrupt-joints-none.fbk", changed(
                                           "joints", [](Bytes& b) { b.assign(4, {}); }, model));
  out.write("corrupt-joints-more.fbk", changed(
                                           "joints", [](Bytes& b) { b.resize(b.size() + 2); }, model));
}

void write_rejected_levels(const RejectedWriter& out) {
  const PackedModel model = levelled_model();
  // After the number of levels, the first has 3 numbers, 5 sizes and 19 corners and texture coordinates.
  constexpr std::size_t coding = 4 + 12 + 4 * 5 + 4 * 19, meshes = coding + 4 + 4 * 19,
                        points = meshes + 4 + 2 * 8 + 3 * 8, weights = points + 4 + 4 * 11,
                        coefficients = weights + 2 * 11;
  out.write("corrupt-no-levels.fbk", changed(
                                         "levels", [](Bytes& b) { b.assign(4, {}); }, model));
  out.write("corrupt-levels-more.fbk", changed(
                                           "levels", [](Bytes& b) { b.resize(b.size() + 2); }, model));
  out.patched("corrupt-level-vertices.fbk", "levels", 4, std::uint32_t(18), model);
  out.patched("corrupt-level-sizes.fbk", "levels", 16, std::uint8_t(5), model);
  out.patched("corrupt-level-corner.fbk", "levels", 16 + 4 * 5, std::uint8_t(8), model);
  out.patched("unsupported-level-uvs.fbk", "levels", coding, std::uint32_t(3), model);
  out.patched("corrupt-level-uvs.fbk", "levels", coding + 4, std::uint8_t(99), model);
  out.patched("corrupt-level-meshes.fbk", "levels", meshes + 4, std::uint32_t(2), model);
  out.patched("corrupt-level-material.fbk", "levels", meshes + 4 + 12, std::uint32_t(2), model);
  out.patched("corrupt-level-triangle.fbk", "levels", points + 4, std::uint8_t(99), model);
  out.patched("corrupt-level-point-mesh.fbk", "levels", points + 4, std::uint8_t(12), model);
  out.patched("corrupt-level-weights.fbk", "levels", weights + 11, std::uint8_t(200), model);
  out.patched("corrupt-level-coefficients.fbk", "levels", coefficients + 4, std::uint8_t(0), model);
  out.patched("corrupt-level-bits.fbk", "levels", coefficients + 4, std::uint8_t(11), model);
  out.patched("unproven-level.fbk", "levels", weights, std::uint8_t(64), model);
  PackedModel other = model;
  other.character.sockets[0].vertices[0] = 0;
  out.patched("corrupt-level-socket.fbk", "sockets", 16, std::uint32_t(3), other);
}

void write_rejected_behaviour(const RejectedWriter& out) {
  out.patched("corrupt-tables.fbk", "weights", 0, std::uint8_t(64));
  out.patched("unsupported-feature.fbk", "network", 4, std::uint8_t(17));
  out.patched("corrupt-feature-control.fbk", "network", 5, std::uint32_t(5));
  out.patched("corrupt-feature-scale.fbk", "network", 9, std::uint32_t(0x7fc00000));
  out.patched("corrupt-feature-threshold.fbk", "network", 31, -1.0f);
  out.patched("corrupt-feature-fall.fbk", "network", 79, -1.0f);
  out.patched("corrupt-feature-loop.fbk", "network", 84, std::uint32_t(7));
  out.patched("corrupt-gate-slope.fbk", "network", 157, 0.0f);
  out.patched("corrupt-gate-slope-infinite.fbk", "network", 157, std::uint32_t(0x7f800000));
  out.patched("unsupported-activation.fbk", "network", 173, std::uint8_t(9));
  out.patched("unsupported-layer-flags.fbk", "network", 174, std::uint8_t(4));
  out.patched("corrupt-columns.fbk", "basis", 0, std::uint32_t(3));
  out.patched("corrupt-ordered.fbk", "basis", 4, std::uint32_t(2));
  out.patched("corrupt-order.fbk", "basis", 8, std::uint8_t(0));
  out.patched("corrupt-rows.fbk", "basis", 132, std::uint8_t(64));
  out.patched("corrupt-segment-block.fbk", "basis", 160, std::uint8_t(9));
  out.patched("corrupt-segment-twice.fbk", "basis", 161, std::uint8_t(0));
  out.patched("corrupt-segment-table.fbk", "basis", 192, std::uint8_t(0xfe));
  out.patched("corrupt-segment-scale.fbk", "basis", 192, std::uint8_t(1));
  out.write("corrupt-scale.fbk", changed("basis", [](Bytes& b) { patch_infinity(b, 204); }));
  out.patched("corrupt-frequencies.fbk", "weights", 4, std::uint16_t(0x7fff));
  out.write("corrupt-few-words.fbk", changed("basis-values", [](Bytes& b) { b.resize(b.size() - 2); }));
  // Without weights, the word counts follow 9 tables that have no frequencies.
  const auto add_word = [](Bytes& b) {
    patch(b, 1 + 9 * 2 + 3 * 4, std::uint32_t(1));
    b.resize(b.size() + 2);
  };
  out.write("corrupt-many-words.fbk", changed("weights", add_word, smallest()));
  const auto coded = [&](const char* file, const Bytes& symbols, const char* section = "basis-values") {
    out.write(file, changed(section, [&](Bytes& b) { b = symbols; }));
  };
  const auto values = [](std::size_t table, std::uint8_t symbol) { return constant_symbols(26, 4, table, symbol); };
  coded("corrupt-predictor.fbk", values(0, 91));
  coded("corrupt-value.fbk", values(25, 31));
  coded("corrupt-class.fbk", values(25, 43));
  coded("corrupt-weight.fbk", constant_symbols(9, 1, 6, 255), "weights");
  Bytes states = values(25, 0);
  patch(states, states.size() - 4, std::uint32_t(65535));
  coded("corrupt-state.fbk", states);
  patch(states, states.size() - 4, std::uint32_t(65537));
  coded("corrupt-final-state.fbk", states);
}

void write_rejected_texts_and_proofs(const RejectedWriter& out) {
  constexpr std::size_t hashes_at = 4 + 11 * 5 * 4, vertices_at = hashes_at + 11 * 8 + 4;
  out.write("corrupt-zero-byte.fbk", changed("licence", [](Bytes& b) { b[3] = std::byte(0); }));
  out.patched("corrupt-proof-control.fbk", "proof", 4, std::uint32_t(0x7fc00000));
  out.patched("corrupt-proof-vertex.fbk", "proof", vertices_at, std::uint32_t(30));
  // Valid archives whose proof does not hold.
  out.patched("unproven-hash.fbk", "proof", hashes_at + 3 * 8, std::uint64_t(1));
  out.patched("unproven-position.fbk", "proof", vertices_at + 16 * 4 + 40, 1e9f);
}

void write_rejected(const std::filesystem::path& folder) {
  const RejectedWriter out(folder);
  write_rejected_containers(out);
  write_rejected_sections(out);
  write_rejected_geometry(out);
  write_rejected_characters(out);
  write_rejected_exact_poses(out);
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
  fb::write_rejected(folder / "rejected");
}
