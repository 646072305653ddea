// Levels of detail in archives: restored as written; inconsistent, cut short or forged ones are refused.
#include <doctest/doctest.h>

#include <functional>

#include "archive/writer.h"
#include "archive_editor.h"
#include "bake/measure/verify.h"
#include "refusals.h"
#include "test_models.h"

namespace fb::test_levels {
namespace {

TEST_CASE("levels are restored, and proven") {
  const PackedModel model = levelled_model();
  const Bytes bytes = write_archive(model, bake::make_proof(model, 1));
  const Archive read = read_archive(bytes);
  CHECK(read.model.levels == model.levels);
  CHECK(read.proof.level_hashes.size() == 4 * read.proof.hashes.size());
  CHECK(bake::verify_archive(bytes).poses == read.proof.hashes.size());
  CHECK(read_archive(bytes, {}, Parts::mesh).model.levels == model.levels);
  CHECK(read_archive(bytes, {}, Parts::behaviour).model.levels.empty());
  CHECK(read_archive(bytes, {}, Parts::proof).proof.level_hashes == read.proof.level_hashes);
  ArchiveEditor archive(bytes);
  Bytes proof = archive["proof"].stored;
  proof.back() ^= std::byte(1);
  archive["proof"].set(proof);
  CHECK_THROWS_WITH_AS(bake::verify_archive(archive.bytes()), doctest::Contains("at level of detail 2"), Error);
}

TEST_CASE("levels that contradict the face or each other are refused") {
  const auto refused = [](const std::function<void(std::vector<DetailLevel>&)>& change, const char* message) {
    PackedModel model = levelled_model();
    change(model.levels);
    CHECK_THROWS_WITH_AS(write_archive(model, {}), doctest::Contains(message), Error);
  };
  using Levels = std::vector<DetailLevel>;
  refused([](Levels& l) { l[0].vertices = 31; }, "level 1 has 31 vertices, the one before it 30");
  refused([](Levels& l) { l[1].vertices = 26; }, "level 2 has 26 vertices, the one before it 19");
  refused([](Levels& l) { l[1].vertices = 0; }, "level 2 has 0 vertices");
  refused([](Levels& l) { l[1].vertices = 12; }, "its 12 vertices are no whole row blocks");
  refused([](Levels& l) { l[0].polygon_sizes[2] = 2; }, "a polygon of 2 corners");
  refused([](Levels& l) { l[0].polygon_sizes[2] = 4; }, "19 corners of polygons of 20");
  refused([](Levels& l) { l[1].polygon_corners[0] = 3; }, "level 2 has a polygon with vertex 3");
  refused([](Levels& l) { l[1].polygon_corners[0] = 30; }, "level 2 has a polygon with vertex 30");
  refused([](Levels& l) { l[0].uv_corners.pop_back(); }, "18 texture coordinates for 19 corners");
  refused([](Levels& l) { l[0].uv_corners[3] = 30; }, "texture coordinates 30 of 30");
  refused([](Levels& l) { l[0].parts.pop_back(); }, "level 1 has 1 meshes of 2");
  refused([](Levels& l) { l[0].parts[0] = {4, {{4, 0}}}; }, "polygon 3 has vertex 18 of another mesh");
  refused([](Levels& l) { l[0].parts[1] = {1, {{1, 0}}}; }, "its meshes have 4 of its 5 polygons");
  refused([](Levels& l) { l[0].parts[1] = {3, {{3, 0}}}; }, "more polygons than its 5");
  refused([](Levels& l) { l[0].parts[0].materials[0].polygons = 1; }, "materials of 2 polygons for 3");
  refused([](Levels& l) { l[0].parts[0].materials.push_back({0, 0}); }, "a material without polygons");
  refused([](Levels& l) { l[0].parts[1].materials[0].material = 2; }, "names material 2 of 2");
  refused([](Levels& l) { l[0].points.pop_back(); }, "level 1 has 10 points for 11 vertices");
  refused([](Levels& l) { l[0].points[0].triangle = 9; }, "vertex 4 lies on triangle 9 of 9");
  refused([](Levels& l) { l[0].points[0].weights = {128, 129}; }, "with weights 128 and 129");
  refused([](Levels& l) { l[0].points[0].triangle = 6; }, "vertex 4 lies on a triangle of another mesh");
  refused([](Levels& l) { l[0].used_coefficients.pop_back(); }, "level 1 has 2 coefficients of 3");
  refused([](Levels& l) { l[1].used_coefficients[2] = 1; }, "level 2 uses coefficient 4");
  refused([](Levels& l) { l.resize(16, l[1]); }, "16 levels of detail; at most 15");
  PackedModel model = levelled_model();
  model.character.sockets[0].vertices[0] = 3;
  CHECK_THROWS_WITH_AS(write_archive(model, {}), doctest::Contains("socket \"nose\" has vertex 3"), Error);
}

TEST_CASE("a section of levels that is cut short, too long, forged or changed never crashes the reader") {
  const Bytes bytes = write_archive(levelled_model(), {});
  const ArchiveEditor whole(bytes);
  ArchiveEditor archive = whole;
  const Bytes contents = archive["levels"].stored;
  for (std::size_t size = 0; size < contents.size(); ++size) {
    archive["levels"].set({contents.begin(), contents.begin() + std::ptrdiff_t(size)});
    REQUIRE(outcome(archive.bytes()).status == Status::corrupt);
  }
  Bytes longer = contents;
  longer.push_back(std::byte(0));
  archive["levels"].set(longer);
  check_refused(archive.bytes(), Status::corrupt, "should end here");
  const auto lie = [&](std::size_t at, auto value, Status status, const char* message) {
    Bytes forged = contents;
    patch(forged, at, value);
    archive["levels"].set(forged);
    check_refused(archive.bytes(), status, message);
  };
  lie(0, std::uint32_t(0), Status::corrupt, "there are no levels");
  lie(0, UINT32_MAX, Status::corrupt, "levels need more than");
  lie(4, std::uint32_t(18), Status::corrupt, "no whole row blocks");
  lie(8, UINT32_MAX, Status::corrupt, "polygon sizes needs");
  lie(12, UINT32_MAX, Status::corrupt, "do not add up");
  lie(16, std::uint8_t(2), Status::corrupt, "less than three corners");
  constexpr std::size_t coding = 16 + 4 * 5 + 4 * 19, meshes = coding + 4 + 4 * 19, points = meshes + 4 + 2 * 8 + 3 * 8;
  lie(coding, std::uint32_t(3), Status::unsupported, "unknown coding 3");
  lie(meshes, UINT32_MAX, Status::corrupt, "meshes need more than");
  lie(points, UINT32_MAX, Status::corrupt, "points need more than");
  lie(points + 4 + 6 * 11, UINT32_MAX, Status::corrupt, "used coefficients needs");
  lie(points + 4 + 6 * 11 + 4, std::uint8_t(11), Status::corrupt, "coefficients that there are not");
  archive["levels"].set(contents);
  for (std::byte& byte : archive["levels"].stored)
    for (const int mask : {0x01, 0x80, 0xff}) {
      byte ^= std::byte(mask);
      const Outcome seen = outcome(archive.bytes(), {std::uint64_t(1) << 24});
      REQUIRE((seen.status == Status::ok || !seen.message.empty()));
      byte ^= std::byte(mask);
    }
  ReadLimits limits;
  limits.max_polygons = 4;
  PackedModel few = levelled_model();
  check_refused(write_archive(few, {}), Status::limit, "polygons", limits);
}

}  // namespace
}  // namespace fb::test_levels
