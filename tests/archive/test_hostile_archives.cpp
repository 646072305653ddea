// Truncated, damaged and forged archives: each is refused with a message.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "archive/reader.h"
#include "archive/writer.h"
#include "archive_editor.h"
#include "base/status.h"
#include "refusals.h"
#include "test_models.h"

namespace fb::test_hostile_archives {
using namespace archive;
namespace {

Bytes tiny_archive() {
  PackedModel model = tiny_packed_model();
  Proof proof;
  proof.controls = model.schema.rest_pose();
  proof.vertices = {3};
  proof.positions = {1, 2, 3};
  proof.hashes = {4};
  return write_archive(model, proof);
}

// Where the Draco data of section "geometry" begins in tiny_archive(), whose mesh has 30 vertices and 34 points.
constexpr std::size_t draco_at = 12 + 4 * 34;

// An archive whose rest mesh is a manifold (the tiny model's is none), its positions multiples of `step`.
Bytes manifold_archive(float step = 0) {
  PackedModel model = tiny_packed_model();
  model.rest = grid_mesh(6, 5);
  if (step > 0)
    for (float& x : model.rest.points) x = std::round(x / step) * step;
  return write_archive(model, {});
}

Bytes text(const std::string& s) {
  const auto bytes = std::as_bytes(std::span(s));
  return {bytes.begin(), bytes.end()};
}

// An archive with one section's contents changed.
Bytes changed(const char* section, const std::function<void(Bytes&)>& change) {
  ArchiveEditor archive(tiny_archive());
  Bytes contents = archive[section].stored;
  change(contents);
  archive[section].set(contents);
  return archive.bytes();
}

}  // namespace

TEST_CASE("the editor reassembles what it opened") {
  const Bytes bytes = ArchiveEditor(tiny_archive()).bytes();
  CHECK(outcome(bytes).status == Status::ok);
}

TEST_CASE("every prefix is refused") {
  const Bytes bytes = tiny_archive();
  check_refused({}, Status::not_an_archive, "empty");
  for (std::size_t size = 1; size < bytes.size(); ++size) {
    const Bytes prefix(
        bytes.begin(),
        bytes.begin() + size);  // an allocation of its own, so that sanitizers detect reads beyond its end
    check_refused(prefix, Status::corrupt, format("truncated: it ends at byte %zu", size));
  }
}

TEST_CASE("every flipped bit is refused") {
  Bytes bytes = tiny_archive();
  std::size_t accepted = 0, silent = 0;
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= std::byte(1 << bit % 8);
    const Outcome seen = outcome(bytes);
    accepted += seen.status == Status::ok;
    silent += seen.message.empty();
    bytes[bit / 8] ^= std::byte(1 << bit % 8);
  }
  CHECK(accepted == 0);
  CHECK(silent == 0);
  CHECK(outcome(bytes).status == Status::ok);
}

TEST_CASE("damage is reported with its offset") {
  Bytes bytes = tiny_archive();
  const auto sections = read_container(bytes);
  for (const StoredSection& section : sections) {
    Bytes damaged = bytes;
    damaged[section.info.offset] ^= std::byte(1);
    check_refused(
        damaged, Status::corrupt,
        format("section \"%s\" (byte %llu)", section.info.name.c_str(), (unsigned long long)section.info.offset));
  }
  Bytes damaged = bytes;
  damaged[table_at(2, 3)] ^= std::byte(1);
  check_refused(damaged, Status::corrupt, "header and section table (bytes 0 to 672)");
  damaged = bytes;
  damaged.back() ^= std::byte(1);
  check_refused(damaged, Status::corrupt, "the whole archive");
}

TEST_CASE("bytes after the end are refused") {
  Bytes bytes = tiny_archive();
  const std::size_t size = bytes.size();
  bytes.push_back(std::byte(0));
  check_refused(bytes, Status::corrupt, format("ends at byte %zu, and 1 more bytes follow", size));
}

TEST_CASE("other files are not archives") {
  check_refused(text("#!/bin/sh\necho hello\n"), Status::not_an_archive, "not an .fbk archive");
  check_refused(text("\x89PNG\r\n\x1a\n and so on and on and on"), Status::not_an_archive, "not an .fbk archive");
  check_refused(Bytes(4096), Status::not_an_archive, "not an .fbk archive");
  Bytes as_text = tiny_archive();
  as_text.erase(as_text.begin() + 4);  // CR LF became LF
  check_refused(as_text, Status::corrupt, "transferred as text");
}

TEST_CASE("other format versions are refused by number") {
  ArchiveEditor archive(tiny_archive());
  archive.minor = 7;
  CHECK(outcome(archive.bytes()).status ==
        Status::ok);  // features of a newer minor version are refused where they occur
  archive.major = 3;
  check_refused(archive.bytes(), Status::unsupported, "format version 3.7; this library reads 2.1");
  archive.major = 0;
  check_refused(archive.bytes(), Status::unsupported, "format version 0.7; this library reads 2.1");
  archive.major = 3;
  archive.minor = 7;
  // A newer version may lay out everything after its number differently.
  Bytes bytes = archive.bytes();
  bytes.resize(40);
  check_refused(bytes, Status::unsupported, "format version 3.7");
}

TEST_CASE("unknown sections are skipped if optional, refused if required") {
  ArchiveEditor archive(tiny_archive());
  archive["hair"].set(text("something newer"));
  const Archive read = read_archive(archive.bytes());
  REQUIRE(read.notes.size() == 1);
  CHECK(contains(read.notes[0], "\"hair\""));
  CHECK(read.sections.back().name == "hair");
  CHECK(read.sections.back().raw_bytes == 15);
  CHECK(!read.sections.back().required);
  archive["hair"].flags = section_required;
  check_refused(archive.bytes(), Status::unsupported, "section \"hair\"");
}

TEST_CASE("sections in another order are read") {
  ArchiveEditor archive(tiny_archive());
  std::reverse(archive.sections.begin(), archive.sections.end());
  CHECK(read_archive(archive.bytes()).model.schema.name == "tiny");
}

TEST_CASE("a missing section is refused by name") {
  for (const char* name : {"definition", "polygons", "geometry", "network", "weights", "basis", "basis-values"}) {
    ArchiveEditor archive(tiny_archive());
    archive[name].name = "gone";
    archive["gone"].flags = 0;
    check_refused(archive.bytes(), Status::corrupt, format("no section \"%s\"", name));
  }
}

TEST_CASE("a forged section table is refused") {
  const Bytes bytes = tiny_archive();
  const auto lie = [&](std::size_t at, auto value, Status status, const char* part) {
    Bytes patched = bytes;
    patch(patched, at, value);
    check_refused(sealed(patched), status, part);
  };
  lie(table_at(1, 40), std::uint64_t(680), Status::corrupt, "overlaps the part before it");
  lie(table_at(1, 40), std::uint64_t(1) << 40, Status::corrupt, "does not follow the part before it");
  lie(table_at(0, 40), std::uint64_t(0), Status::corrupt, "overlaps the part before it");
  lie(table_at(6, 48), UINT64_MAX, Status::corrupt, "runs past byte");
  lie(table_at(0, 48), UINT64_MAX - 679, Status::corrupt, "runs past byte");
  lie(table_at(0, 0), std::uint64_t(0), Status::corrupt, "section name");
  lie(table_at(0, 8), std::uint64_t(0x0a), Status::corrupt, "not printable ASCII");
  lie(table_at(0, 32), std::uint32_t(2), Status::unsupported, "unknown flags 0x2");
  lie(table_at(1, 36), std::uint32_t(9), Status::unsupported, "unknown codec 9");
  lie(table_at(1, 56), std::uint64_t(1) << 50, Status::corrupt, "larger than 4 GiB");
  lie(table_at(1, 56), std::uint64_t(1) << 20, Status::corrupt, "does not decompress to the 1048576 bytes");
  lie(table_at(1, 36), std::uint32_t(0), Status::corrupt, "not compressed, yet declares");

  Bytes many = bytes;
  patch(many, 12, std::uint32_t(65));
  check_refused(many, Status::corrupt, "declares 65 sections");
  ArchiveEditor archive(bytes);
  archive.sections.push_back(archive.sections[0]);
  check_refused(archive.bytes(), Status::corrupt, "already is a section of this name");
  archive.sections.pop_back();
  archive.sections.pop_back();
  Bytes gap = archive.bytes();
  gap.insert(gap.end() - 8, std::byte(0));
  patch(gap, 16, std::uint64_t(gap.size()));
  check_refused(sealed(gap), Status::corrupt, "the last section ends at byte");
}

TEST_CASE("a compressed section is one deflate stream and nothing more") {
  const Bytes bytes = tiny_archive();
  const auto followed_by = [&](const Bytes& more) {
    ArchiveEditor archive(bytes);
    const StoredSection packed = read_container(bytes)[1];
    REQUIRE(packed.codec == Codec::deflate);
    ArchiveEditor::Section& section = archive[packed.info.name];
    section = {packed.info.name, section_required, 1, packed.info.raw_bytes,
               Bytes(packed.stored.begin(), packed.stored.end())};
    section.stored.insert(section.stored.end(), more.begin(), more.end());
    return archive.bytes();
  };
  CHECK(outcome(followed_by({})).status == Status::ok);
  check_refused(followed_by(text("x")), Status::corrupt, "does not decompress to the");
  ArchiveEditor other(bytes);
  const StoredSection packed = read_container(bytes)[1];
  other["polygons"] = {"polygons", section_required, 1, packed.info.raw_bytes + 1,
                       Bytes(packed.stored.begin(), packed.stored.end())};
  check_refused(other.bytes(), Status::corrupt, "does not decompress to the");
  other["polygons"].raw_bytes -= 2;
  check_refused(other.bytes(), Status::corrupt, "does not decompress to the");
}

TEST_CASE("forged contents are refused by section") {
  const auto lie = [&](const char* section, std::size_t at, auto value, Status status, const char* part) {
    check_refused(changed(section, [&](Bytes& b) { patch(b, at, value); }), status, part);
  };
  lie("definition", 0, UINT32_MAX, Status::corrupt, "section \"definition\"");
  lie("definition", 19, std::uint32_t(31), Status::corrupt, "section \"geometry\"");
  lie("definition", 19, UINT32_MAX, Status::corrupt, "more vertices than the format allows");
  lie("definition", 23, UINT32_MAX, Status::corrupt, "controls need more than");
  lie("polygons", 0, UINT32_MAX, Status::corrupt, "polygon sizes needs 17179869180 bytes");
  lie("polygons", 4, std::uint32_t(7), Status::corrupt, "do not add up");
  lie("geometry", 0, std::uint32_t(29), Status::corrupt, "fewer points than vertices");
  lie("geometry", 0, UINT32_MAX, Status::corrupt, "vertices of points needs");
  lie("geometry", 4, UINT32_MAX, Status::corrupt, "more triangles than the format allows");
  lie("geometry", 4, std::uint32_t(9), Status::corrupt, "more points than corners");
  lie("geometry", 8, 0.75f, Status::corrupt, "no power of two");
  lie("geometry", 8, std::uint32_t(0x7f800000), Status::corrupt, "no power of two");
  lie("geometry", 8, 0.5f, Status::corrupt, "of another kind than the format allows");
  lie("geometry", 12, std::uint8_t(61), Status::corrupt, "a vertex that does not exist");
  lie("geometry", draco_at, std::uint8_t(0), Status::corrupt, "of another kind than the format allows");
  lie("geometry", draco_at + 12, std::uint8_t(33), Status::corrupt, "another number of points or faces");
  lie("geometry", draco_at + 14, std::uint8_t(1), Status::corrupt, "seams");
  lie("geometry", draco_at + 15, std::uint8_t(1), Status::corrupt, "the number of symbols");
  lie("polygons", 8 + 4 * 21, std::uint8_t(200), Status::corrupt, "no edge of a triangle");
  lie("network", 0, UINT32_MAX, Status::corrupt, "features need more than");
  lie("network", 4, std::uint8_t(17), Status::unsupported, "unknown kind 17");
  lie("network", 5, std::uint32_t(5), Status::corrupt, "names control 5 of 5");
  lie("network", 9, std::uint32_t(0x7fc00000), Status::corrupt, "feature 0 has scale nan");
  lie("network", 84, std::uint32_t(7), Status::corrupt, "feature 7 is made of feature 7");
  lie("network", 157, 0.0f, Status::corrupt, "a gate of slope 0");
  lie("network", 173, std::uint8_t(9), Status::unsupported, "unknown activation 9");
  lie("network", 174, std::uint8_t(4), Status::unsupported, "unknown flags 0x4");
  lie("basis", 0, std::uint32_t(3), Status::corrupt, "section \"basis\"");
  lie("basis", 4, std::uint32_t(2), Status::corrupt, "the order flag is neither 0 nor 1");
  lie("basis", 8, std::uint8_t(0), Status::corrupt, "the order does not list every vertex once");
  lie("basis", 11, std::uint8_t(0xff), Status::corrupt, "the order does not list every vertex once");
  lie("basis", 128, UINT32_MAX, Status::corrupt, "row blocks need more than");
  lie("basis", 132, std::uint8_t(64), Status::corrupt, "do not add up to the number of rows");
  lie("basis", 140, UINT32_MAX, Status::corrupt, "row blocks of segments needs");
  lie("basis", 160, std::uint8_t(9), Status::corrupt, "a row block that does not exist");
  lie("basis", 161, std::uint8_t(0), Status::corrupt, "lies twice in one row block");
  lie("basis", 192, std::uint8_t(0xfe), Status::corrupt, "a segment has a table that does not exist");
  lie("basis", 192, std::uint8_t(1), Status::corrupt, "a column has no scale");
  lie("basis", 200, UINT32_MAX, Status::corrupt, "scales need more than");
  check_refused(changed("basis", [](Bytes& b) { patch_infinity(b, 204); }), Status::corrupt,
                "scale that is not finite");
  lie("weights", 0, std::uint8_t(8), Status::corrupt, "no such number of tables");
  lie("weights", 0, std::uint8_t(10), Status::corrupt, "no such number of tables");
  lie("weights", 1, std::uint16_t(300), Status::corrupt, "does not fit a byte");
  lie("weights", 4, std::uint16_t(0x7fff), Status::corrupt, "frequencies of symbols are too");
  lie("basis-values", 0, std::uint8_t(24), Status::corrupt, "no such number of tables");
  lie("basis-values", 0, std::uint8_t(90), Status::corrupt, "no such number of tables");
  lie("basis-values", 1, std::uint16_t(0xffff), Status::corrupt, "does not fit a byte");
  lie("proof", 0, UINT32_MAX, Status::corrupt, "proof controls needs");
  lie("proof", 36, std::uint32_t(30), Status::corrupt, "names a vertex that does not exist");
}

TEST_CASE("values beyond their range, or too few of them, are refused") {
  const auto weights = [](std::size_t table, std::uint8_t symbol) {
    return changed("weights", [&](Bytes& b) { b = constant_symbols(9, 1, table, symbol); });
  };
  const auto values = [](const Bytes& contents) { return changed("basis-values", [&](Bytes& b) { b = contents; }); };
  constexpr std::size_t pairs = 0, classes = 25;  // tables
  const auto basis = [&](std::size_t table, std::uint8_t symbol, std::uint32_t words = 0) {
    return values(constant_symbols(26, 4, table, symbol, words));
  };
  CHECK(outcome(basis(classes, 0)).status == Status::ok);  // all values 0
  check_refused(basis(classes, 31), Status::corrupt, "a value beyond its range");
  check_refused(basis(classes, 43), Status::corrupt, "a class that does not exist");
  check_refused(basis(classes, 255), Status::corrupt, "a class that does not exist");
  check_refused(basis(classes, 33), Status::corrupt, "too few coded symbols");
  check_refused(basis(pairs, 91), Status::corrupt, "a predictor that does not exist");
  check_refused(basis(classes, 0, 1), Status::corrupt, "too many coded symbols");
  check_refused(weights(6, 255), Status::corrupt, "holds a weight beyond its range");
  CHECK(outcome(weights(0, 127)).status == Status::corrupt);
  const Bytes states = constant_symbols(26, 4, classes, 0);
  const std::size_t last_part = states.size() - 32;
  for (const std::size_t part : {last_part - 3 * 32, last_part})
    for (const std::size_t stream : {0u, 3u}) {
      Bytes wrong = states;
      patch(wrong, part + 16 + 4 * stream, std::uint32_t(65535));
      check_refused(values(wrong), Status::corrupt, "state is too small");
      patch(wrong, part + 16 + 4 * stream, std::uint32_t(65537));
      check_refused(values(wrong), Status::corrupt, "does not end in its final state");
      patch(wrong = states, part + 4 * stream, UINT32_MAX);
      check_refused(values(wrong), Status::corrupt, "do not fill the section");
    }
}

TEST_CASE("forged texture coordinates are refused") {
  const auto lie = [](bool by_vertex, std::size_t at, auto value, Status status, const char* message) {
    PackedModel model = tiny_packed_model();
    by_vertex ? give_uvs_by_vertex(model.rest) : give_uvs(model.rest);
    ArchiveEditor archive(write_archive(model, {}));
    Bytes contents = archive["uvs"].stored;
    patch(contents, at, value);
    if (by_vertex) patch(contents, 8 + 2 * 30, std::uint8_t(0x80));  // see below
    archive["uvs"].set(contents);
    check_refused(archive.bytes(), status, message);
  };
  lie(false, 0, std::uint32_t(0), Status::corrupt, "there are no texture coordinates");
  lie(false, 0, UINT32_MAX, Status::corrupt, "texture coordinates needs");
  lie(false, 4, std::uint32_t(2), Status::unsupported, "unknown coding 2");
  lie(false, 4, std::uint32_t(1), Status::corrupt, "not that of the vertices");
  lie(false, 8 + 8 * 60, std::uint8_t(120), Status::corrupt, "names a texture coordinate that does not exist");
  lie(true, 4, std::uint32_t(0), Status::corrupt, "corners needs");
  lie(true, 8 + 3 * 30, std::uint8_t(0x7f), Status::corrupt, "not finite");  // the rest of infinity
}

TEST_CASE("contents cut short or too long are refused") {
  const ArchiveEditor whole(tiny_archive());
  for (std::size_t s = 0; s < whole.sections.size(); ++s) {
    if (whole.sections[s].name == "provenance") continue;  // any text is one
    INFO(whole.sections[s].name);
    ArchiveEditor archive = whole;
    std::size_t accepted = 0;
    for (std::size_t size = 0; size < whole.sections[s].stored.size(); ++size) {
      archive.sections[s].set({whole.sections[s].stored.begin(), whole.sections[s].stored.begin() + size});
      accepted += outcome(archive.bytes()).status == Status::ok;
    }
    CHECK(accepted == 0);
    Bytes longer = whole.sections[s].stored;
    longer.push_back(std::byte(0));
    archive.sections[s].set(longer);
    const bool coded = whole.sections[s].name == "weights" || whole.sections[s].name == "basis-values";
    check_refused(archive.bytes(), Status::corrupt, coded ? "do not fill the section" : "should end here");
  }
}

// With valid checksums, a changed byte may give another valid model, but never a crash or unbounded memory.
TEST_CASE("changed contents never crash the reader") {
  for (const Bytes& bytes : {tiny_archive(), manifold_archive(), manifold_archive(0x1p-8f)}) {
    const ArchiveEditor whole(bytes);
    ArchiveEditor archive = whole;
    for (std::size_t s = 0; s < whole.sections.size(); ++s) {
      for (std::size_t at = 0; at < whole.sections[s].stored.size(); ++at)
        for (const int mask : {0x01, 0x80, 0xff}) {
          archive.sections[s].stored[at] ^= std::byte(mask);
          const Outcome seen = outcome(archive.bytes(), {std::uint64_t(1) << 24});
          REQUIRE((seen.status == Status::ok || !seen.message.empty()));
          archive.sections[s].stored[at] ^= std::byte(mask);
        }
    }
  }
}

TEST_CASE("the caller's memory limit is kept") {
  const Bytes bytes = tiny_archive();
  check_refused(bytes, Status::limit, "beyond the limit of 4000 bytes", {4000});
  CHECK(outcome(bytes, {1000000}).status == Status::ok);
  for (std::uint64_t limit = 0; limit < 1000000; limit += 4999) {
    const Status status = outcome(bytes, {limit}).status;
    REQUIRE((status == Status::limit || status == Status::ok));
  }
}

}  // namespace fb::test_hostile_archives
