// Files that went wrong once, in tests/fixtures/cases, through the tool: what it writes, and what it says.
#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "archive/writer.h"
#include "base/file.h"
#include "glb_reading.h"
#include "gltf_avatar.h"
#include "picture_reading.h"
#include "signed_volume.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"
#include "usd_reading.h"

namespace test_tool_cases {

using namespace fb;
using namespace fb::test;

namespace {

std::string case_file(const std::string& name) {
  return (std::filesystem::path(FB_CASES) / name).string();
}

ToolRun bake(const ScratchFolder& folder, const std::string& source, std::vector<std::string> more = {}) {
  more.insert(more.begin(), {"bake", source, "--recipe", "linear", "--poses", "20", "--out", folder / "face.fbk"});
  return run_tool(more);
}

// Six times the volumes of the meshes of a .glb.
std::vector<double> glb_volumes(const std::string& path) {
  const tinygltf::Model model = load_glb(path);
  std::vector<double> volumes;
  for (const tinygltf::Mesh& mesh : model.meshes)
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      const std::vector<float> points = floats(model, primitive.attributes.at("POSITION"));
      const tinygltf::Accessor& indices = model.accessors.at(std::size_t(primitive.indices));
      std::vector<std::uint32_t> corners;
      if (indices.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT)
        for (const std::uint16_t corner :
             view_values<std::uint16_t>(model, indices.bufferView, indices.byteOffset, indices.count))
          corners.push_back(corner);
      else
        corners = view_values<std::uint32_t>(model, indices.bufferView, indices.byteOffset, indices.count);
      volumes.push_back(signed_volume(points, 0, points.size() / 3, corners.data(), corners.size() / 3));
    }
  return volumes;
}

// Likewise of a .usda.
std::vector<double> usd_volumes(const std::string& path) {
  const auto bytes = read_file(path);
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto points = lists_of(text, "point3f[] points"), corners = lists_of(text, "int[] faceVertexIndices"),
             counts = lists_of(text, "int[] faceVertexCounts");
  REQUIRE(!points.empty());
  REQUIRE(points.size() == corners.size());
  CHECK(text.find("leftHanded") == std::string::npos);
  std::vector<double> volumes;
  for (std::size_t m = 0; m < points.size(); ++m) {
    for (const float count : counts[m]) REQUIRE(count == 3);
    const std::vector<std::uint32_t> indices(corners[m].begin(), corners[m].end());
    volumes.push_back(signed_volume(points[m], 0, points[m].size() / 3, indices.data(), indices.size() / 3));
  }
  return volumes;
}

// Of all faces of an .obj.
double obj_volume(const std::string& path) {
  const auto bytes = read_file(path);
  std::istringstream lines(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  std::vector<float> points;
  std::vector<std::uint32_t> corners;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line.size() > 2 ? line.substr(2) : "");
    if (line.starts_with("v "))
      for (float value; words >> value;) points.push_back(value);
    if (line.starts_with("f "))
      for (std::string word; words >> word;) corners.push_back(static_cast<std::uint32_t>(std::stoul(word)) - 1);
  }
  return signed_volume(points, 0, points.size() / 3, corners.data(), corners.size() / 3);
}

}  // namespace

TEST_CASE("what nodes mirror is written with its faces outwards") {
  for (const char* file : {"mirror.glb", "head_mirrored.glb"}) {
    CAPTURE(std::string(file));
    const ScratchFolder folder;
    const ToolRun baked = bake(folder, case_file(file));
    REQUIRE_MESSAGE(baked.exit_code == 0, baked.err);
    REQUIRE(run_tool({"pose", folder / "face.fbk", "--out", folder / "face.glb"}).exit_code == 0);
    for (const double volume : glb_volumes(folder / "face.glb")) CHECK(volume > 0);
    REQUIRE(run_tool({"pose", folder / "face.fbk", "--out", folder / "face.OBJ"}).exit_code == 0);
    CHECK(obj_volume(folder / "face.OBJ") > 0);
    REQUIRE(run_tool({"export", folder / "face.fbk", folder / "face.usda"}).exit_code == 0);
    for (const double volume : usd_volumes(folder / "face.usda")) CHECK(volume > 0);
  }
}

TEST_CASE("a picture of a mirrored head is that of the head") {
  // Both are symmetric: seen from the front they look the same, with faces that point away the mirrored one would not.
  const ScratchFolder plain, mirrored;
  REQUIRE(bake(plain, case_file("repeated_key_times.glb")).exit_code == 0);
  REQUIRE(bake(mirrored, case_file("head_mirrored.glb")).exit_code == 0);
  for (const ScratchFolder* folder : {&plain, &mirrored})
    REQUIRE(run_tool({"pose", *folder / "face.fbk", "--yaw", "0", "--pitch", "0", "--size", "64x64", "--out",
                      *folder / "face.PNG"})
                .exit_code == 0);
  const Picture one = read_picture(read_file(plain / "face.PNG")), two = read_picture(read_file(mirrored / "face.PNG"));
  REQUIRE(one.pixels.size() == 3 * 64 * 64);
  REQUIRE(two.pixels.size() == one.pixels.size());
  CHECK(std::set(one.pixels.begin(), one.pixels.end()).size() > 16);  // a shaded head, no empty picture
  std::size_t other = 0;
  for (std::size_t i = 0; i < one.pixels.size(); ++i) other += std::abs(one.pixels[i] - two.pixels[i]) > 8;
  CHECK(other < one.pixels.size() / 50);
}

TEST_CASE("takes with semicolons and in UTF-16 are read") {
  const ScratchFolder folder;
  PackedModel model = tiny_packed_model();
  model.schema.controls[0].labels.arkit = "jawOpen";
  write_file(folder / "face.fbk", archive::write_archive(model, {}));
  std::vector<std::string> files;
  for (const char* name : {"semicolon.csv", "utf16.csv"}) {
    const ToolRun run = run_tool({"pose", folder / "face.fbk", "--livelink", case_file(name), "--frame", "5", "--out",
                                  folder / (std::string(name) + ".obj")});
    CHECK_MESSAGE(run.exit_code == 0, run.err);
    CHECK(run.err.find("no controls have the names \"EyeBlinkLeft\"") != std::string::npos);
  }
  CHECK(read_file(folder / "semicolon.csv.obj") == read_file(folder / "utf16.csv.obj"));
}

TEST_CASE("names that are none are refused with those there are") {
  const ScratchFolder folder;
  const std::string avatar = folder / "avatar.GLB";
  {
    GltfAvatar written;
    std::ofstream(avatar, std::ios::binary) << written.glb();
  }
  const auto refused = [&](const std::vector<std::string>& more, const std::vector<std::string>& words) {
    const ToolRun run = bake(folder, avatar, more);
    CHECK(run.exit_code != 0);
    CHECK_MESSAGE(is_error_line(run.err, "bake", words), run.err);
  };
  refused({"--control-joint", "Nek"},
          {"no joint or node \"Nek\"", "the closest is \"Neck\"", "there are \"Armature\", \"Neck\", \"Head\""});
  refused({"--control-joint", "Neck", "--control-joint", "jaw*"},
          {"no joint or node \"jaw*\"", "there are \"Armature\""});
  const ToolRun exact = run_tool(
      {"bake", avatar, "--recipe", "compact", "--poses", "20", "--exact", "tlk", "--out", folder / "face.fbk"});
  CHECK(exact.exit_code != 0);
  CHECK_MESSAGE(exact.err.find("the closest clip is \"talk\"; it has \"talk\"") != std::string::npos, exact.err);
  const ToolRun set = run_tool({"bake", avatar, "--recipe", "linear", "--poses", "20", "--out", folder / "face.fbk"});
  REQUIRE(set.exit_code == 0);
  CHECK(set.err.find("--control-joint NAME one: \"Neck\", \"Head\"") != std::string::npos);
  write_file(folder / "faces.txt", std::string("ann=") + avatar + "\n");
  const ToolRun farm = run_tool({"farm", folder / "faces.txt", "--out", folder / "farm", "--only", "bob"});
  CHECK(farm.exit_code != 0);
  CHECK_MESSAGE(is_error_line(farm.err, "farm", {"no character \"bob\"", "there are \"ann\""}), farm.err);
}

TEST_CASE("broken meshes are left out if that is asked for, also of a rig in a child") {
  const ScratchFolder folder;
  GltfAvatar avatar;
  avatar.json["meshes"][3]["primitives"][0]["attributes"]["POSITION"] = 999;
  std::ofstream(folder / "avatar.glb", std::ios::binary) << avatar.glb();
  const ToolRun refused = bake(folder, folder / "avatar.glb");
  CHECK(is_error_line(refused.err, "bake", {"mesh \"tongue\": no accessor 999 for its positions"}));
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--skip-broken"}, std::vector<std::string>{"--skip-broken", "--isolate"}}) {
    const ToolRun run = bake(folder, folder / "avatar.glb", more);
    CHECK_MESSAGE(run.exit_code == 0, run.err);
    CHECK_MESSAGE(run.err.find("left out, as it cannot be read: mesh \"tongue\"") != std::string::npos, run.err);
  }
}

}  // namespace test_tool_cases
