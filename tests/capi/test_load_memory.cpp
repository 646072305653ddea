// fb_load_desc::max_model_bytes bounds what loading takes: archives made to take much of one thing are loaded by
// children whose address space has no room for more.
#include <doctest/doctest.h>
#include <facebaker/facebaker.h>

#include <cstdio>
#include <string>
#include <vector>

#include "archive/container/byte_writer.h"
#include "archive/container/container_writer.h"
#include "archive/geometry/corner_coding.h"
#include "archive/geometry/geometry_reader.h"
#include "archive/writer.h"
#include "archive_editor.h"
#include "base/file.h"
#include "temporary_folder.h"
#include "test_models.h"

namespace fb {
namespace {

constexpr std::uint64_t mebibyte = 1 << 20;

// Room for what is not counted: the library's own state, and free pieces between blocks of the heap.
std::uint64_t spare_of(std::uint64_t limit) {
  return mebibyte + limit / 8;
}
// Large blocks have pages of their own, without free pieces.
constexpr std::uint64_t spare_of_large_blocks = mebibyte;

struct Outcome {
  int status = -1;
  unsigned long long grown = 0;  // by how many bytes the process grew at most
};

// Loads an archive in a process of its own that has no more memory than `limit` and `spare`; limit 0: as much as it
// needs.
Outcome load_within(const Bytes& archive, std::uint64_t limit, std::uint64_t spare) {
  const test::Folder folder;
  write_file(folder.path() / "face.fbk", archive);
  const std::string command = format("%s %s %llu %llu", FB_LOAD_WITHIN, (folder.path() / "face.fbk").c_str(),
                                     (unsigned long long)limit, (unsigned long long)spare);
  std::FILE* const child = ::popen(command.c_str(), "r");
  REQUIRE(child);
  Outcome outcome;
  const int numbers = std::fscanf(child, "%d %llu", &outcome.status, &outcome.grown);
  REQUIRE_MESSAGE((::pclose(child) == 0 && numbers == 2), command);
  return outcome;
}

Outcome load_within(const Bytes& archive, std::uint64_t limit) {
  return load_within(archive, limit, spare_of(limit));
}

void check_bounded(const char* name, const Bytes& archive) {
  const Outcome free = load_within(archive, 0);
  REQUIRE_MESSAGE(free.status == FB_OK, std::string(name));
  MESSAGE(std::string(name), ": an archive of ", archive.size() >> 10, " KiB takes ", free.grown >> 10, " KiB");
  CHECK_MESSAGE(load_within(archive, free.grown / 4).status == FB_ERROR_LIMIT, std::string(name));
  for (const unsigned quarters : {2, 3, 4}) {
    const int status = load_within(archive, free.grown / 4 * quarters).status;
    CHECK_MESSAGE((status == FB_OK || status == FB_ERROR_LIMIT), std::string(name), ", ", quarters, ": status ",
                  status);
  }
  CHECK_MESSAGE(load_within(archive, free.grown / 2 * 3).status == FB_OK, std::string(name));
}

// An archive of which nearly all is a few large blocks is refused at `limit`, and loaded at what it takes, without ever
// exceeding either by more than spare_of_large_blocks.
void check_bounded_closely(const char* name, const Bytes& archive, std::uint64_t limit) {
  const Outcome free = load_within(archive, 0);
  REQUIRE_MESSAGE(free.status == FB_OK, std::string(name));
  MESSAGE(std::string(name), ": an archive of ", archive.size() >> 10, " KiB takes ", free.grown >> 10, " KiB");
  CHECK(load_within(archive, limit, spare_of_large_blocks).status == FB_ERROR_LIMIT);
  CHECK(load_within(archive, free.grown - spare_of_large_blocks, spare_of_large_blocks).status == FB_ERROR_LIMIT);
  CHECK(load_within(archive, free.grown + spare_of_large_blocks, spare_of_large_blocks).status == FB_OK);
}

void check_bounded(const char* name, const PackedModel& model) {
  check_bounded(name, archive::write_archive(model, {}));
}

// Compresses the contents of a section.
void deflate(ArchiveEditor::Section& section) {
  archive::WrittenSection written = archive::compressed_section(section.name.c_str(), true, std::move(section.stored));
  section.codec = static_cast<std::uint32_t>(written.codec);
  section.stored = std::move(written.stored);
}

// The archive of a model with its first polygon, a quad, repeated: `count` more polygons of `turns` times its corners.
// Written by hand, because coding such a mesh takes long.
Bytes with_polygons(const PackedModel& model, std::uint32_t count, std::uint32_t turns) {
  ArchiveEditor archive(archive::write_archive(model, {}));
  const std::vector<std::uint32_t>& quad = model.rest.polygon_corners;
  std::vector<std::uint32_t> sizes = model.rest.polygon_sizes, corners = quad;
  sizes.insert(sizes.end(), count, 4 * turns);
  for (std::uint32_t turn = 0; turn < count * turns; ++turn)
    corners.insert(corners.end(), quad.begin(), quad.begin() + 4);
  archive::ByteWriter out;
  out.count(sizes.size(), "polygons");
  out.count(corners.size(), "corners");
  out.planes(sizes);
  out.numbers(std::vector<std::uint8_t>(sizes.size(), archive::no_edge));
  out.planes(archive::corner_deltas(sizes, corners));
  archive["polygons"].set(out.bytes);
  deflate(archive["polygons"]);
  return archive.bytes();
}

// A grid of vertices in baked order, moved in row blocks of these sizes by the first coefficient.
PackedModel with_vertices(std::uint32_t columns, std::uint32_t rows, std::uint32_t block_rows) {
  PackedModel model = tiny_packed_model();
  model.rest = grid_mesh(columns, rows);
  model.order.clear();
  model.row_blocks.clear();
  const auto all = static_cast<std::uint32_t>(model.rest.points.size());
  for (std::uint32_t first = 0; first < all; first += block_rows) {
    const std::uint32_t count = std::min(block_rows, all - first);
    model.row_blocks.push_back({first, count, {{0, false, 0.01f}}, std::pmr::vector<std::int16_t>(count, 1)});
  }
  return model;
}

}  // namespace

TEST_CASE("polygons take no more memory than allowed") {
  PackedModel model = tiny_packed_model();
  check_bounded("quads", with_polygons(model, 150000, 1));
  check_bounded("large polygons", with_polygons(model, 100, 750));
  give_uvs_by_vertex(model.rest);
  check_bounded("textured quads", with_polygons(model, 60000, 1));
}

TEST_CASE("a file of kilobytes that unpacks to hundreds of megabytes takes no more memory than allowed") {
  check_bounded_closely("3 million quads", with_polygons(tiny_packed_model(), 3000000, 1), 94000000);
  PackedModel model = tiny_packed_model();
  for (int i = 0; i < 1500; ++i) {
    Control control = model.schema.controls[0];
    control.name = std::to_string(i) + std::string(65000, 'n');
    control.group = std::string(65000, 'g');
    model.schema.controls.push_back(control);
  }
  check_bounded_closely("195 MB of names", archive::write_archive(model, {}), 200000000);
}

TEST_CASE("vertices and row blocks take no more memory than allowed") {
  check_bounded("a grid", with_vertices(150, 100, 3 * 64));
  check_bounded("row blocks of one row", with_vertices(50, 40, 1));
  PackedModel points = with_vertices(150, 100, 3 * 64);
  points.rest.polygon_sizes.clear();
  points.rest.polygon_corners.clear();
  check_bounded("points", points);
}

TEST_CASE("names and texts take no more memory than allowed") {
  PackedModel model = tiny_packed_model();
  for (int i = 0; i < 100; ++i) {
    Control control = model.schema.controls[0];
    control.name = std::to_string(i) + std::string(60000, 'n');
    control.group = std::string(60000, 'g');
    model.schema.controls.push_back(control);
  }
  check_bounded("long names", model);
  model = tiny_packed_model();
  for (int i = 0; i < 30000; ++i) {
    Control control = model.schema.controls[0];
    control.name = "a_control_with_a_name_" + std::to_string(i);
    model.schema.controls.push_back(control);
  }
  check_bounded("many names", model);
  model = tiny_packed_model();
  model.provenance = std::string(8 << 20, 'p');
  check_bounded("a text", model);
}

TEST_CASE("features, regions and weights take no more memory than allowed") {
  PackedModel model = tiny_packed_model();
  const auto first = static_cast<std::uint32_t>(model.features.size());
  for (std::uint32_t f = 0; f < 50000; ++f) {
    model.features.push_back({Feature::Kind::identity, f % 5, 1, 0});
    model.features.push_back({Feature::Kind::product, 0, 1, 0, 0, f % first, (f + 1) % first});
  }
  check_bounded("features", model);

  model = tiny_packed_model();
  PackedLayer layer{1500, 1500, Activation::linear, false, false, std::pmr::vector<std::int16_t>(1500 * 1500), {}, {}};
  layer.scales.assign(1500, 1);
  layer.bias.assign(1500, 0);
  Random random(1);
  PackedRegion& region = model.regions[0];
  region.layers = {random_packed_layer(random, 6, 1500, Activation::relu, false, false), layer,
                   random_packed_layer(random, 1500, 2, Activation::linear, false, true)};
  check_bounded("weights", model);

  model = tiny_packed_model();
  for (int r = 0; r < 3000; ++r) model.regions.push_back(model.regions[1]);
  model.columns += 3000;
  check_bounded("regions", model);
}

TEST_CASE("a face of the usual size loads within one and a half times of what it takes") {
  Random random(5);
  PackedModel model = tiny_packed_model();
  model.rest = grid_mesh(100, 80);
  give_uvs(model.rest);
  model.order.clear();
  model.row_blocks.clear();
  model.features.resize(6);
  for (std::uint32_t c = 0; c < 400; ++c) {
    Control control = model.schema.controls[0];
    control.name = "control_" + std::to_string(c);
    model.schema.controls.push_back(control);
    model.features.push_back({Feature::Kind::identity, 5 + c, 1, 0});
  }
  model.direct.clear();
  std::vector<std::uint32_t> all_features, columns;
  for (std::uint32_t f = 0; f < model.features.size(); ++f) all_features.push_back(f);
  const auto inputs = static_cast<std::uint32_t>(all_features.size());
  model.regions = {{"face",
                    all_features,
                    {random_packed_layer(random, inputs, 256, Activation::silu, false, false),
                     random_packed_layer(random, 256, 256, Activation::silu, true, false),
                     random_packed_layer(random, 256, 48, Activation::linear, false, false)},
                    {}}};
  model.columns = 48;
  for (std::uint32_t c = 0; c < 48; ++c) columns.push_back(c);
  for (std::uint32_t row = 0; row < 24000; row += 64)
    model.row_blocks.push_back(random_row_block(random, row, std::min(64u, 24000 - row), columns, 0.5f));
  const Bytes archive = archive::write_archive(model, {});
  check_bounded("a face of the usual size", archive);
}

}  // namespace fb
