// Meshes, materials and images of an archive: what is inconsistent, cut short or forged is refused.
#include <doctest/doctest.h>

#include <functional>

#include "archive/writer.h"
#include "archive_editor.h"
#include "refusals.h"
#include "test_models.h"

namespace fb::test_characters {
namespace {

const char* const sections[] = {"meshes", "materials", "images", "sockets", "channels"};

void check_unwritable(const std::function<void(PackedModel&)>& change, const char* message) {
  PackedModel model = character_model();
  change(model);
  CHECK_THROWS_WITH_AS(write_archive(model, {}), doctest::Contains(message), Error);
}

TEST_CASE("meshes that do not make up the whole are refused") {
  using Model = PackedModel;
  check_unwritable([](Model& m) { m.rest.parts[0].name.clear(); }, "a mesh without a name");
  check_unwritable([](Model& m) { m.rest.parts[1].name = "head"; }, "two meshes named \"head\"");
  check_unwritable([](Model& m) { m.rest.parts[0].vertices = 0; }, "mesh \"head\" has no vertices");
  check_unwritable([](Model& m) { m.rest.parts[1].vertices = 13; }, "mesh \"teeth\" has more vertices");
  check_unwritable([](Model& m) { m.rest.parts[1].vertices = UINT32_MAX; }, "mesh \"teeth\" has more vertices");
  check_unwritable([](Model& m) { m.rest.parts[1].polygons = 6; }, "mesh \"teeth\" has more vertices or polygons");
  check_unwritable([](Model& m) { m.rest.parts[0].polygons = 11; }, "polygon 10 has vertex 18 of another mesh");
  check_unwritable([](Model& m) { m.rest.parts.pop_back(); }, "18 vertices and 10 polygons of 30 and 15");
  check_unwritable([](Model& m) { m.rest.parts[0].materials[0].polygons = 5; }, "materials of 9 polygons for 10");
  check_unwritable([](Model& m) { m.rest.parts[0].materials.push_back({0, 0}); }, "a material without polygons");
  check_unwritable([](Model& m) { m.rest.parts[1].materials[0].material = 2; }, "names material 2 of 2");
  check_unwritable(
      [](Model& m) {
        Random random(1);
        m.row_blocks = {random_row_block(random, 0, 57, {0}, 1), random_row_block(random, 57, 33, {0}, 1),
                        random_row_block(random, 90, 6, {0}, 1)};
      },
      "row block 0 has vertices of two meshes");
}

TEST_CASE("materials that contradict themselves are refused") {
  using Model = PackedModel;
  const auto skin = [](Model& m) -> Material& { return m.character.materials[0]; };
  check_unwritable([&](Model& m) { skin(m).roughness = NAN; }, "material 0 (\"skin\") has a factor that is not finite");
  check_unwritable([&](Model& m) { skin(m).emissive[2] = INFINITY; }, "not finite");
  check_unwritable([&](Model& m) { skin(m).textures[1].scale = NAN; }, "not finite");
  check_unwritable([&](Model& m) { skin(m).textures[1].image = 3; }, "image 3 of 3");
  check_unwritable([&](Model& m) { skin(m).textures[1].slot = TextureSlot::base_colour; }, "two textures in one slot");
}

TEST_CASE("sockets that cannot follow a surface are refused") {
  using Model = PackedModel;
  const auto nose = [](Model& m) -> Socket& { return m.character.sockets[0]; };
  check_unwritable([&](Model& m) { nose(m).name = "tooth"; }, "two sockets named \"tooth\"");
  check_unwritable([&](Model& m) { nose(m).name = ""; }, "a socket without a name");
  check_unwritable([&](Model& m) { nose(m).vertices.resize(2); }, "socket \"nose\" has 2 vertices");
  check_unwritable([&](Model& m) { nose(m).weights.pop_back(); }, "4 weights for 5 vertices");
  check_unwritable([&](Model& m) { nose(m).vertices[4] = 30; }, "names vertex 30 of 30");
  check_unwritable([&](Model& m) { nose(m).vertices[4] = 18; }, "vertices of two meshes");
  check_unwritable([&](Model& m) { nose(m).weights[1] = 0; }, "a weight of 0");
  check_unwritable([&](Model& m) { nose(m).weights[1] = INFINITY; }, "a weight of inf");
  check_unwritable([&](Model& m) { nose(m).frame[11] = NAN; }, "its frame is not finite");
}

TEST_CASE("channels that contradict themselves or the basis are refused") {
  using Model = PackedModel;
  const auto channel = [](Model& m, std::size_t c) -> Channel& { return m.schema.channels[c]; };
  check_unwritable([&](Model& m) { channel(m, 1).name = "frown"; }, "channel name \"frown\" occurs twice");
  check_unwritable([&](Model& m) { channel(m, 0).name = ""; }, "channel 0 has no name");
  check_unwritable([&](Model& m) { channel(m, 3).minimum = 320; }, "channel \"heat\": minimum 320 is not below");
  check_unwritable([&](Model& m) { channel(m, 3).rest = 321; }, "channel \"heat\": default 321 is outside");
  check_unwritable([&](Model& m) { channel(m, 2).maximum = INFINITY; }, "channel \"eye_turn\": its range");
  check_unwritable([&](Model& m) { channel(m, 2).scale = 0; }, "channel \"eye_turn\" has the scale 0");
  check_unwritable([&](Model& m) { channel(m, 2).scale = NAN; }, "has the scale nan");
  check_unwritable([&](Model& m) { m.schema.channels.pop_back(); }, "2 vertices carry 3 channels");
  check_unwritable([&](Model& m) { m.rest.points[95] = 1; }, "a vertex that carries numbers is not 0 at rest");
  check_unwritable([&](Model& m) { std::swap(m.order[30], m.order[31]); },
                   "lists vertices behind those that carry numbers");
  check_unwritable([&](Model& m) { m.rest.polygon_corners[0] = 30; }, "names vertex 30 of 30");
  check_unwritable(
      [](Model& m) {
        Random random(1);
        m.row_blocks.resize(2);
        m.row_blocks.push_back(random_row_block(random, 54, 42, {0}, 1));
      },
      "row block 2 has vertices of two meshes");
}

TEST_CASE("labels that contradict each other are refused") {
  using Model = PackedModel;
  const auto labels = [](Model& m, std::size_t c) -> ControlLabels& { return m.schema.controls[c].labels; };
  check_unwritable([&](Model& m) { labels(m, 1).arkit = "jawOpen"; }, "two controls have the ARKit name \"jawOpen\"");
  check_unwritable([&](Model& m) { labels(m, 1).facs = "AU26"; }, "two controls have the FACS name \"AU26\"");
  check_unwritable([&](Model& m) { labels(m, 1).mirror = "ear"; }, "mirrors \"ear\", which is no control");
  check_unwritable([&](Model& m) { labels(m, 1).mirror = "lid_close"; }, "which does not mirror it");
  check_unwritable([&](Model& m) { labels(m, 1).mirror = "mouth_side"; }, "which does not mirror it");
}

TEST_CASE("forged sections of a character are refused by name") {
  const Bytes bytes = write_archive(character_model(), {});
  const auto lie = [&](const char* section, std::size_t at, auto value, Status status, const char* message) {
    ArchiveEditor archive(bytes);
    Bytes contents = archive[section].stored;
    patch(contents, at, value);
    archive[section].set(contents);
    check_refused(archive.bytes(), status, message);
  };
  lie("meshes", 0, std::uint32_t(1), Status::corrupt, "should end here");
  lie("meshes", 0, UINT32_MAX, Status::corrupt, "meshes need more than");
  lie("meshes", 4, UINT32_MAX, Status::corrupt, "section \"meshes\"");
  lie("meshes", 20, UINT32_MAX, Status::corrupt, "material runs need more than");
  lie("meshes", 28, std::uint32_t(2), Status::corrupt, "names material 2 of 2");
  lie("materials", 0, UINT32_MAX, Status::corrupt, "materials need more than");
  lie("materials", 48, std::uint8_t(3), Status::unsupported, "unknown number 3 for an alpha mode");
  lie("materials", 53, std::uint8_t(3), Status::unsupported, "unknown flags 0x3");
  lie("materials", 54, UINT32_MAX, Status::corrupt, "textures need more than");
  lie("materials", 58, std::uint8_t(5), Status::unsupported, "unknown number 5 for a texture's slot");
  lie("materials", 59, std::uint8_t(3), Status::unsupported, "unknown number 3 for a texture's wrap");
  lie("images", 0, UINT32_MAX, Status::corrupt, "images need more than");
  lie("images", 4 + 8 + 13, UINT32_MAX, Status::corrupt, "an image needs");
  lie("labels", 0, UINT32_MAX, Status::corrupt, "section \"labels\"");
  lie("labels", 30, std::uint32_t(5), Status::corrupt, "a mirror partner that does not exist");
  lie("labels", 30, std::uint32_t(1), Status::corrupt, "which does not mirror it");
  lie("sockets", 0, UINT32_MAX, Status::corrupt, "sockets need more than");
  lie("sockets", 12, UINT32_MAX, Status::corrupt, "vertices of a socket need more than");
  lie("channels", 0, UINT32_MAX, Status::corrupt, "channels need more than");
  lie("channels", 4 + 4 + 5 + 4, 2.0f, Status::corrupt, "minimum 2 is not below maximum 1");
  lie("channels", 4 + 4 + 5 + 4 + 12, -1.0f, Status::corrupt, "has the scale -1");
  lie("sockets", 16, std::uint32_t(30), Status::corrupt, "names vertex 30 of 30");
  for (const char* section : sections) {
    ArchiveEditor archive(bytes);
    archive[section].set(Bytes(4));
    check_refused(archive.bytes(), Status::corrupt, "there are no");
  }
}

TEST_CASE("sections of a character that are cut short, too long or changed never crash the reader") {
  const ArchiveEditor whole(write_archive(character_model(), {}));
  for (const std::string name : {"labels", "meshes", "materials", "images", "sockets", "channels", "expected-errors"}) {
    INFO(name);
    ArchiveEditor archive = whole;
    const Bytes contents = archive[name].stored;
    for (std::size_t size = 0; size < contents.size(); ++size) {
      archive[name].set({contents.begin(), contents.begin() + std::ptrdiff_t(size)});
      REQUIRE(outcome(archive.bytes()).status == Status::corrupt);
    }
    Bytes longer = contents;
    longer.push_back(std::byte(0));
    archive[name].set(longer);
    check_refused(archive.bytes(), Status::corrupt, "should end here");
    archive[name].set(contents);
    for (std::byte& byte : archive[name].stored)
      for (const int mask : {0x01, 0x80, 0xff}) {
        byte ^= std::byte(mask);
        const Outcome seen = outcome(archive.bytes(), {std::uint64_t(1) << 24});
        REQUIRE((seen.status == Status::ok || !seen.message.empty()));
        byte ^= std::byte(mask);
      }
  }
}

TEST_CASE("what is said about a character is text, and its thumbnail a square picture") {
  using Model = PackedModel;
  check_unwritable([](Model& m) { m.character.about = "{\xff}"; }, "no UTF-8 text at byte 1");
  check_unwritable([](Model& m) { m.character.about = std::string("{\0}", 3); }, "no UTF-8 text at byte 1");
  check_unwritable([](Model& m) { m.character.about.resize(65537, ' '); }, "has 65537 bytes; it may have 65536");
  check_unwritable([](Model& m) { m.character.thumbnail.resize(23); }, "the thumbnail is no PNG");
  check_unwritable([](Model& m) { m.character.thumbnail[19] = std::byte(2); }, "2 x 1 pixels");
  check_unwritable([](Model& m) { m.character.thumbnail[19] = m.character.thumbnail[23] = std::byte(0); },
                   "0 x 0 pixels");
  check_unwritable([](Model& m) { m.character.thumbnail.resize(65537); }, "has 65537 bytes; it may have 65536");
  PackedModel largest = character_model();
  largest.character.about.resize(65536, ' ');
  largest.character.thumbnail.resize(65536);
  for (const std::size_t edge : {18, 22}) largest.character.thumbnail[edge] = std::byte(2);
  for (const std::size_t edge : {19, 23}) largest.character.thumbnail[edge] = std::byte(0);
  CHECK(read_archive(write_archive(largest, {})).model.character == largest.character);
}

TEST_CASE("forged texts and thumbnails are refused by name, and cut ones never crash the reader") {
  const Bytes bytes = write_archive(character_model(), {});
  const auto forged = [&](const char* section, const std::function<void(Bytes&)>& change, const char* message) {
    ArchiveEditor archive(bytes);
    Bytes contents = archive[section].stored;
    change(contents);
    archive[section].set(contents);
    check_refused(archive.bytes(), Status::corrupt, message);
  };
  forged(
      "about", [](Bytes& b) { b[3] = std::byte(0xff); }, "no UTF-8 text at byte 3");
  forged(
      "about", [](Bytes& b) { b[3] = std::byte(0); }, "section \"about\"");
  forged(
      "about", [](Bytes& b) { b.resize(65537, std::byte(' ')); }, "has 65537 bytes");
  forged(
      "thumbnail", [](Bytes& b) { b[1] = std::byte('G'); }, "the thumbnail is no PNG");
  forged(
      "thumbnail", [](Bytes& b) { b[12] = std::byte('J'); }, "the thumbnail is no PNG");
  forged(
      "thumbnail", [](Bytes& b) { b[16] = std::byte(1); }, "16777217 x 1 pixels");
  forged(
      "thumbnail", [](Bytes& b) { b.resize(65537); }, "has 65537 bytes");
  forged(
      "thumbnail", [](Bytes& b) { b.clear(); }, "there is no thumbnail");
  for (const std::string name : {"about", "thumbnail"}) {
    ArchiveEditor archive(bytes);
    const Bytes contents = archive[name].stored;
    for (std::size_t size = 0; size < contents.size(); ++size) {
      archive[name].set({contents.begin(), contents.begin() + std::ptrdiff_t(size)});
      const Status status = outcome(archive.bytes()).status;
      REQUIRE((status == Status::corrupt || (status == Status::ok && (name == "about" || size >= 24))));
    }
    archive[name].set(contents);
    for (std::byte& byte : archive[name].stored)
      for (const int mask : {0x01, 0x80, 0xff}) {
        byte ^= std::byte(mask);
        const Outcome seen = outcome(archive.bytes(), {std::uint64_t(1) << 24});
        REQUIRE((seen.status == Status::ok || !seen.message.empty()));
        byte ^= std::byte(mask);
      }
  }
}

TEST_CASE("expected errors that contradict the face are refused") {
  using Model = PackedModel;
  check_unwritable([](Model& m) { m.expected.unit = 0; }, "the unit is 0");
  check_unwritable([](Model& m) { m.expected.unit = INFINITY; }, "the unit is inf");
  check_unwritable([](Model& m) { m.expected.regions[1].name = "mouth"; }, "two regions named \"mouth\"");
  check_unwritable([](Model& m) { m.expected.regions[1].name = ""; }, "without a name");
  check_unwritable([](Model& m) { m.expected.regions[0].constant = -1; }, "\"mouth\" has the constant -1");
  check_unwritable([](Model& m) { m.expected.regions[0].constant = NAN; }, "has the constant");
  check_unwritable([](Model& m) { m.expected.runs[0].vertices = 8; }, "regions of 29 vertices for 30");
  check_unwritable([](Model& m) { m.expected.runs[0].vertices = 0; }, "0 vertices of region 0");
  check_unwritable([](Model& m) { m.expected.runs[0].region = 2; }, "of region 2 of 2");
  check_unwritable([](Model& m) { m.expected.runs[1].region = 0; }, "\"brows, upper left\" has no vertices");
  check_unwritable([](Model& m) { m.expected.weights.pop_back(); }, "weights");
  check_unwritable([](Model& m) { m.expected.trained_low[1] = 201; }, "was trained from 201 to 200");
  check_unwritable([](Model& m) { m.expected.untrained_pairs.back() |= 0x80; }, "pairs of controls that there are not");
  check_unwritable([](Model& m) { m.expected.regions.resize(65, {"x", 0}); }, "65 regions; at most 64");

  const Bytes bytes = write_archive(character_model(), {});
  const auto lie = [&](std::size_t at, auto value, const char* message) {
    ArchiveEditor archive(bytes);
    Bytes contents = archive["expected-errors"].stored;
    patch(contents, at, value);
    archive["expected-errors"].set(contents);
    check_refused(archive.bytes(), Status::corrupt, message);
  };
  lie(0, std::uint32_t(0x7fc00000), "the unit is nan");
  lie(4, UINT32_MAX, "regions need more than");
  lie(46, UINT32_MAX, "runs of vertices need more than");
  lie(4, std::uint32_t(0), "there are no regions");
}

TEST_CASE("exact poses that contradict the face are refused") {
  const auto check_exact = [](const std::function<void(std::vector<ExactPose>&)>& change, const char* message) {
    PackedModel model = exact_model();
    change(model.exact);
    CHECK_THROWS_WITH_AS(write_archive(model, {}), doctest::Contains(message), Error);
  };
  using Poses = std::vector<ExactPose>;
  check_exact([](Poses& p) { p[1].name = "smile:12"; }, "two exact poses named \"smile:12\"");
  check_exact([](Poses& p) { p[0].name.clear(); }, "or one without a name");
  check_exact([](Poses& p) { p[0].controls[1] = 7; }, "\"smile:12\" has control");
  check_exact([](Poses& p) { p[0].controls[1] = NAN; }, "outside of its range");
  check_exact([](Poses& p) { p[0].controls.pop_back(); }, "has 4 controls and 96 values for 5 and 96");
  check_exact([](Poses& p) { p[0].values.pop_back(); }, "has 5 controls and 95 values");
  check_exact([](Poses& p) { p[0].values[3] = largest_correction + 1; }, "has the value 16777216");
  check_exact([](Poses& p) { p[0].step = 0; }, "and the step 0");
  check_exact([](Poses& p) { p[0].falloff = INFINITY; }, "has the falloff inf");
  check_exact([](Poses& p) { p[1].falloff = 1e-3f; }, "\"frown:0\" reaches the rest pose");
  check_exact([](Poses& p) { p.resize(1025); }, "1025 exact poses; at most 1024");
}

TEST_CASE("exact poses that are forged, cut or too long are refused, and need be understood") {
  ArchiveEditor archive(write_archive(exact_model(), {}));
  CHECK(archive["exact-poses"].flags == section_required);
  const Bytes contents = archive["exact-poses"].stored;
  const auto lie = [&](std::size_t at, auto value, const char* message) {
    Bytes changed = contents;
    patch(changed, at, value);
    archive["exact-poses"].set(changed);
    check_refused(archive.bytes(), Status::corrupt, message);
  };
  lie(0, std::uint32_t(0), "there are no exact poses");
  lie(0, UINT32_MAX, "exact poses need more than");
  lie(0, std::uint32_t(1), "should end here");
  lie(4, UINT32_MAX, "section \"exact-poses\"");
  lie(16, std::uint32_t(0x7fc00000), "outside of its range");
  for (std::size_t size = 0; size < contents.size(); ++size) {
    archive["exact-poses"].set({contents.begin(), contents.begin() + std::ptrdiff_t(size)});
    REQUIRE(outcome(archive.bytes()).status == Status::corrupt);
  }
  Bytes longer = contents;
  longer.push_back(std::byte(0));
  archive["exact-poses"].set(longer);
  check_refused(archive.bytes(), Status::corrupt, "should end here");
  archive["exact-poses"].set(contents);
  for (std::byte& byte : archive["exact-poses"].stored)
    for (const int mask : {0x01, 0x80, 0xff}) {
      byte ^= std::byte(mask);
      const Outcome seen = outcome(archive.bytes(), {std::uint64_t(1) << 24});
      REQUIRE((seen.status == Status::ok || !seen.message.empty()));
      byte ^= std::byte(mask);
    }
}

TEST_CASE("weights of expected errors are bytes with a floating point") {
  CHECK(decoded_weight(0) == 0);
  CHECK(decoded_weight(255) == 15.0f / 16);
  CHECK(decoded_weight(1) == 9 * 0x1p-35f);
  for (int code = 1; code < 256; ++code) CHECK(encoded_weight(decoded_weight(static_cast<std::uint8_t>(code))) == code);
  for (double weight = 1e-9; weight < 0.9; weight *= 1.037)
    CHECK(decoded_weight(encoded_weight(weight)) == doctest::Approx(weight).epsilon(1.0 / 16));
  CHECK(encoded_weight(0) == 0);
  CHECK(encoded_weight(1e-30) == 0);
  CHECK(encoded_weight(7) == 255);
}

TEST_CASE("names and pictures of a character count towards the limits") {
  PackedModel model = character_model();
  model.rest.parts[1].name = std::string(2000, 'n');
  model.character.about.clear();
  const Bytes named = write_archive(model, {});
  ReadLimits limits;
  limits.max_name_bytes = 1900;
  check_refused(named, Status::limit, "bytes of names and texts", limits);
  model = character_model();
  model.character.images[0].bytes.resize(1 << 20);
  const Bytes pictured = write_archive(model, {});
  check_refused(pictured, Status::limit, "beyond the limit", {std::uint64_t(1) << 20});
  CHECK(outcome(pictured, {std::uint64_t(1) << 23}).status == Status::ok);
}

}  // namespace
}  // namespace fb::test_characters
