// An avatar goes the whole way: from glTF with files beside it through bake and pose to glTF, which is a rig again.
#include <doctest/doctest.h>

#include <cmath>
#include <fstream>

#include "bake/dataset/open_source.h"
#include "bake/rig/source.h"
#include "gltf_avatar.h"
#include "skinning.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_avatar {

using namespace fb;
using namespace fb::test;

namespace {

// Writes the avatar with its buffer and one image in files beside it.
void write_avatar(const ScratchFolder& folder, GltfAvatar& avatar) {
  avatar.json["buffers"][0]["uri"] = "avatar.bin";
  avatar.json["images"][1] = {{"name", "skin"}, {"uri", "skin.png"}};
  std::ofstream(folder / "avatar.gltf") << avatar.json.dump();
  std::ofstream(folder / "avatar.bin", std::ios::binary) << avatar.buffer();
  std::ofstream(folder / "skin.png", std::ios::binary) << std::string(skin_png.begin(), skin_png.end());
}

bool has(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

// The same joints, but for rounding, and the same skin.
void check_joints(const Character& first, const Character& second) {
  REQUIRE(second.joints.size() == first.joints.size());
  for (std::size_t j = 0; j < first.joints.size(); ++j) {
    CHECK(second.joints[j].name == first.joints[j].name);
    CHECK(second.joints[j].parent == first.joints[j].parent);
    for (std::size_t i = 0; i < 12; ++i) {
      CHECK(second.joints[j].rest[i] == doctest::Approx(first.joints[j].rest[i]).epsilon(1e-5));
      CHECK(second.joints[j].inverse_bind[i] == doctest::Approx(first.joints[j].inverse_bind[i]).epsilon(1e-5));
    }
  }
  CHECK(second.skin == first.skin);
}

}  // namespace

TEST_CASE("an avatar that is baked and written again is the same avatar") {
  const ScratchFolder folder;
  GltfAvatar avatar;
  write_avatar(folder, avatar);
  const auto first = bake::open_source(folder / "avatar.gltf");
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, std::vector<std::string>{"--isolate"}}) {
    CAPTURE(more.size());
    std::vector<std::string> arguments = {"bake",  folder / "avatar.gltf", "--recipe", "linear", "--poses", "60",
                                          "--out", folder / "avatar.fbk"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ToolRun baked = run_tool(arguments);
    REQUIRE_MESSAGE(baked.exit_code == 0, baked.err);
    REQUIRE(run_tool({"pose", folder / "avatar.fbk", "--control-targets", "--out", folder / "again.glb"}).exit_code ==
            0);
    const auto second = bake::open_source(folder / "again.glb");
    CHECK(second->rest().parts == first->rest().parts);
    CHECK(second->character().materials == first->character().materials);
    CHECK(second->character().images == first->character().images);
    check_joints(first->character(), second->character());
    CHECK(second->rest().polygon_corners == first->rest().polygon_corners);
    REQUIRE(second->rest().points.size() == first->rest().points.size());

    for (const std::map<std::string, double>& weights :
         {std::map<std::string, double>{}, {{"jawOpen", 1}}, {{"tongueOut", 0.5}, {"browInnerUp", 1}}}) {
      std::vector<float> pose = second->schema().rest_pose(), points(second->rest().points.size());
      for (const auto& [name, weight] : weights)
        pose.at(second->schema().find(name).value()) = static_cast<float>(weight);
      second->evaluate(pose, 1, points);
      const std::vector<double> expected = avatar.points(weights),
                                found = skinned(second->character(), joint_places(second->character()), points);
      double worst = 0;
      for (std::size_t i = 0; i < points.size(); ++i) worst = std::max(worst, std::abs(found[i] - expected[i]));
      CHECK(worst < 1e-5 * first->rest().diagonal());
    }
  }
}

TEST_CASE("an avatar's joints are controls where that is asked for, in this process and in children") {
  const ScratchFolder folder;
  GltfAvatar avatar;
  write_avatar(folder, avatar);
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, std::vector<std::string>{"--isolate"}}) {
    std::vector<std::string> arguments = {
        "bake",  folder / "avatar.gltf", "--joints", "controls", "--recipe", "linear", "--poses", "60",
        "--out", folder / "joints.fbk"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ToolRun baked = run_tool(arguments);
    REQUIRE_MESSAGE(baked.exit_code == 0, baked.err);
    CHECK_MESSAGE(has(baked.err, "2 joints are controls (2), and move joints of the face"), baked.err);
    const ToolRun posed =
        run_tool({"pose", folder / "joints.fbk", "--set", "Neck.rz=30", "--out", folder / "turned.obj"});
    CHECK_MESSAGE(posed.exit_code == 0, posed.err);
    // It has no clips of split test: all are measured on, and that is said.
    arguments = {"eval", folder / "joints.fbk", folder / "avatar.gltf", "--joints", "controls", "--json", "-"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ToolRun measured = run_tool(arguments);
    REQUIRE_MESSAGE(measured.exit_code == 0, measured.err);
    CHECK_MESSAGE(has(measured.err, "the rig has no clips of split test: measured on all its clips"), measured.err);
    CHECK(has(measured.out, "\"nod\""));
  }
  const ToolRun other = run_tool({"eval", folder / "joints.fbk", folder / "avatar.gltf"});
  CHECK(other.exit_code != 0);
  const ToolRun named =
      run_tool({"bake", folder / "avatar.gltf", "--control-joint", "Haed", "--out", folder / "no.fbk"});
  CHECK_MESSAGE(is_error_line(named.err, "bake", {"avatar.gltf", "no joint or node \"Haed\""}), named.err);
  const ToolRun sample = run_tool({"bake", "sample", "--joints", "ignore", "--out", folder / "no.fbk"});
  CHECK_MESSAGE(is_error_line(sample.err, "bake", {"no source is a glTF file"}), sample.err);
}

TEST_CASE("a file without animations is measured on poses that are drawn for it") {
  const ScratchFolder folder;
  GltfAvatar avatar;
  avatar.json.erase("animations");
  write_avatar(folder, avatar);
  const ToolRun baked =
      run_tool({"bake", folder / "avatar.gltf", "--recipe", "linear", "--poses", "60", "--out", folder / "avatar.fbk"});
  REQUIRE_MESSAGE(baked.exit_code == 0, baked.err);
  const ToolRun measured = run_tool({"eval", folder / "avatar.fbk", folder / "avatar.gltf"});
  REQUIRE_MESSAGE(measured.exit_code == 0, measured.err);
  CHECK_MESSAGE(has(measured.err, "\"avatar\" has no clips: 500 poses are drawn to measure on, of seed 1"),
                measured.err);
  CHECK(has(measured.out, "synthetic_shots"));
  const ToolRun chosen = run_tool({"eval", folder / "avatar.fbk", folder / "avatar.gltf", "--split", "test"});
  CHECK(chosen.exit_code != 0);
}

TEST_CASE("an avatar without an image that it names is baked with a note, without a buffer refused by its name") {
  const ScratchFolder folder;
  GltfAvatar avatar;
  write_avatar(folder, avatar);
  const std::string gltf = folder / "avatar.gltf", archive = folder / "avatar.fbk";
  const std::vector<std::string> bake = {"bake", gltf, "--recipe", "linear", "--poses", "60", "--out", archive};
  std::filesystem::remove(folder / "skin.png");
  const ToolRun without_image = run_tool(bake);
  CHECK_MESSAGE(without_image.exit_code == 0, without_image.err);
  CHECK_MESSAGE(has(without_image.err, "cannot be read: image 1 (\"skin\"): no such file"), without_image.err);
  CHECK(std::filesystem::remove(archive));
  std::filesystem::remove(folder / "avatar.bin");
  const ToolRun without_buffer = run_tool(bake);
  CHECK(without_buffer.exit_code != 0);
  CHECK_MESSAGE(is_error_line(without_buffer.err, "bake", {"avatar.gltf", "avatar.bin", "no such file"}),
                without_buffer.err);
  CHECK_FALSE(std::filesystem::exists(archive));
}

}  // namespace test_tool_avatar
