// Thumbnails of baked characters: their materials, and of a body what moves, as in the pictures that `pose` draws.
#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "base/file.h"
#include "gltf_avatar.h"
#include "picture_reading.h"
#include "render/palette_png.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_thumbnails {

using namespace fb;
using namespace fb::test;

namespace {

void bake_avatar(const ScratchFolder& folder, const std::string& glb, const std::string& archive,
                 const std::vector<std::string>& more = {}) {
  std::ofstream(folder / "character.glb", std::ios::binary) << glb;
  std::vector<std::string> arguments = {
      "bake", folder / "character.glb", "--recipe", "linear", "--poses", "60", "--out", archive};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ToolRun run = run_tool(arguments);
  REQUIRE_MESSAGE(run.exit_code == 0, run.err);
}

Picture thumbnail_of(const std::string& archive) {
  return read_picture(archive::read_archive(read_file(archive)).model.character.thumbnail);
}

Picture posed_picture(const ScratchFolder& folder, const std::string& archive,
                      const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"pose", archive, "--size", "192x192", "--out", folder / "pose.png"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  REQUIRE(run_tool(arguments).exit_code == 0);
  return read_picture(read_file(folder / "pose.png"));
}

// Of all channels, the mean.
double difference(const Picture& a, const Picture& b) {
  REQUIRE(a.pixels.size() == b.pixels.size());
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += std::abs(double(a.pixels[i]) - double(b.pixels[i]));
  return sum / double(a.pixels.size());
}

// Pixels in which green stands out.
std::size_t green_pixels(const Picture& picture) {
  std::size_t count = 0;
  for (std::size_t p = 0; p + 2 < picture.pixels.size(); p += 3)
    count += picture.pixels[p + 1] > 50 + std::max(picture.pixels[p], picture.pixels[p + 2]);
  return count;
}

// An avatar whose skin has a green texture.
std::string green_avatar() {
  GltfAvatar avatar;
  const std::vector<std::byte> png = tool::palette_png(tool::Image(4, 4, {20, 200, 40}));
  avatar.json["images"][1]["bufferView"] = avatar.more().view(png.data(), png.size());
  avatar.json["materials"][1]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, 1};
  return avatar.glb();
}

// A strip of 20 in height, of which one morph target moves the uppermost two.
std::string tall_body() {
  constexpr std::uint16_t rows = 41;
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};
  GltfBuffer buffer(json);
  std::vector<float> points, offsets;
  std::vector<std::uint16_t> corners;
  for (std::uint16_t r = 0; r < rows; ++r) {
    const float y = 0.5f * r, bend = std::sin(y);
    points.insert(points.end(), {-1, y, bend, 1, y, 0.5f * bend});
    for (int side = 0; side < 2; ++side) offsets.insert(offsets.end(), {0, 0, y > 18 ? 0.25f : 0});
    if (r + 1 == rows) break;
    const auto at = static_cast<std::uint16_t>(2 * r);
    for (const int corner : {at + 0, at + 1, at + 3, at + 0, at + 3, at + 2})
      corners.push_back(static_cast<std::uint16_t>(corner));
  }
  const int positions = buffer.accessor(points, "VEC3", 3), moves = buffer.accessor(offsets, "VEC3", 3),
            indices = buffer.accessor(corners, "SCALAR", 1);
  json["nodes"] = {{{"name", "body"}, {"mesh", 0}}};
  json["meshes"] = {
      {{"primitives",
        {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"targets", {{{"POSITION", moves}}}}}}},
       {"extras", {{"targetNames", {"nod"}}}}}};
  return glb_file(json, buffer.data);
}

}  // namespace

TEST_CASE("a bake of a textured avatar has a thumbnail in the colours of its texture, on any number of threads") {
  const ScratchFolder folder;
  const std::string one = folder / "one.fbk", three = folder / "three.fbk", bare = folder / "bare.fbk";
  bake_avatar(folder, green_avatar(), one, {"--threads", "1"});
  bake_avatar(folder, green_avatar(), three, {"--threads", "3"});
  CHECK(read_file(one) == read_file(three));
  const Picture picture = thumbnail_of(one);
  CHECK(picture.width == 192);
  CHECK(green_pixels(picture) > 500);
  CHECK(difference(picture, posed_picture(folder, one)) < 2);

  GltfAvatar clay;
  clay.json.erase("materials");
  for (auto& mesh : clay.json["meshes"])
    for (auto& primitive : mesh["primitives"]) primitive.erase("material");
  bake_avatar(folder, clay.glb(), bare);
  CHECK(green_pixels(thumbnail_of(bare)) == 0);
}

TEST_CASE("the thumbnail of a body shows what moves, drawn by bake or by pack") {
  const ScratchFolder folder;
  const std::string archive = folder / "body.fbk", plain = folder / "plain.fbk", packed = folder / "packed.fbk";
  bake_avatar(folder, tall_body(), archive);
  const Picture head = posed_picture(folder, archive), whole = posed_picture(folder, archive, {"--whole"});
  REQUIRE(difference(head, whole) > 10);
  CHECK(difference(thumbnail_of(archive), head) < 2);

  bake_avatar(folder, tall_body(), plain, {"--no-thumbnail"});
  CHECK(archive::read_archive(read_file(plain)).model.character.thumbnail.empty());
  REQUIRE(run_tool({"pack", plain, "--out", packed, "--thumbnail"}).exit_code == 0);
  CHECK(read_file(packed) == read_file(archive));
}

}  // namespace test_tool_thumbnails
