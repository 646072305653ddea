// Expressions of VRM avatars, of both versions.
#include <cmath>
#include <fstream>

#include "bake/rig/gltf/gltf_rig.h"
#include "bake_test_support.h"
#include "gltf_avatar.h"
#include "skinning.h"

namespace test_gltf_expressions {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;
using nlohmann::json;

namespace {

// Opened by path, as a .vrm.
OpenedSource open_vrm(const GltfAvatar& avatar) {
  static const Folder folder;
  std::ofstream(folder / "avatar.vrm", std::ios::binary) << avatar.glb();
  return open_source(folder / "avatar.vrm");
}

std::vector<double> points_of(Source& rig, const std::map<std::string, double>& values) {
  std::vector<float> pose = rig.schema().rest_pose(), points(rig.rest().points.size());
  for (const auto& [name, value] : values) pose.at(rig.schema().find(name).value()) = static_cast<float>(value);
  rig.evaluate(pose, 1, points);
  return skinned(rig.character(), joint_places(rig.character()), points);
}

void check_same(const std::vector<double>& found, const std::vector<double>& expected) {
  REQUIRE(found.size() == expected.size());
  double worst = 0;
  for (std::size_t i = 0; i < found.size(); ++i) worst = std::max(worst, std::abs(found[i] - expected[i]));
  CHECK(worst < 2e-6);
}

std::string notes_of(const Source& rig) {
  std::string all;
  for (const std::string& note : rig.notes()) all += note + "\n";
  return all;
}

std::vector<std::string> control_names(const Source& rig) {
  std::vector<std::string> names;
  for (const Control& control : rig.schema().controls) names.push_back(control.name);
  return names;
}

}  // namespace

TEST_CASE("expressions of VRM 0 are controls that move morph targets by their shares") {
  GltfAvatar avatar;
  avatar.json["extensionsUsed"] = {"VRM"};
  avatar.json["extensions"]["VRM"]["blendShapeMaster"]["blendShapeGroups"] = {
      {{"name", "A"},
       {"presetName", "a"},
       {"binds", {{{"mesh", 0}, {"index", 0}, {"weight", 50}}, {{"mesh", 3}, {"index", 0}, {"weight", 100}}}}},
      {{"name", "Smug"},
       {"presetName", "unknown"},
       {"isBinary", true},
       {"binds", {{{"mesh", 0}, {"index", 2}, {"weight", 100}}, {{"mesh", 0}, {"index", 9}, {"weight", 100}}}},
       {"materialValues", {{{"materialName", "skin"}}}}},
      {{"name", "browInnerUp"}, {"binds", {{{"mesh", 0}, {"index", 1}, {"weight", 100}}}}},
      {{"name", "tongueOut"}, {"binds", {{{"mesh", 3}, {"index", 0}, {"weight", 30}}}}},
      {{"name", "Neutral"}, {"presetName", "neutral"}, {"binds", json::array()}}};
  const auto rig = open_vrm(avatar);
  // What is a morph target already is left as it is; what has its name alone has another.
  CHECK(control_names(*rig) == std::vector<std::string>{"jawOpen", "browInnerUp", "mouthSmileLeft", "tongueOut", "a",
                                                        "Smug", "tongueOut (2)"});
  const Control& a = rig->schema().controls[4];
  CHECK((a.minimum == 0 && a.maximum == 1 && a.rest == 0));
  // The jaw of the head alone, for the teeth are of another mesh.
  GltfAvatar half;
  half.parts[3].targets.clear();
  half.parts[4].targets.erase("jawOpen");
  check_same(points_of(*rig, {{"a", 1}}), half.points({{"jawOpen", 0.5}, {"tongueOut", 1}}));
  check_same(points_of(*rig, {{"Smug", 0.5}, {"jawOpen", 0.25}, {"tongueOut (2)", 1}}),
             avatar.points({{"mouthSmileLeft", 0.5}, {"jawOpen", 0.25}, {"tongueOut", 0.3}}));
  const std::string notes = notes_of(*rig);
  CHECK(contains(notes, "what expressions do to materials is left out: \"Smug\""));
  CHECK(contains(notes, "binary expressions move smoothly here: \"Smug\""));
  CHECK(contains(notes, "parts of expressions that name no morph target are left out: \"Smug\""));
  CHECK(rig->clips().at(0).controls.size() == rig->clips()[0].frames * 7);
}

TEST_CASE("expressions of VRM 1 name nodes") {
  GltfAvatar avatar;
  avatar.json["extensionsUsed"] = {"VRMC_vrm"};
  avatar.json["extensionsRequired"] = {"VRMC_materials_mtoon"};
  const json jaw = {{"node", int(GltfAvatar::head_mesh)}, {"index", 0}, {"weight", 0.5}},
             teeth = {{"node", int(GltfAvatar::teeth_mesh)}, {"index", 0}, {"weight", 0.5}},
             tongue = {{"node", int(GltfAvatar::tongue_mesh)}, {"index", 1}, {"weight", 0.5}},
             nothing = {{"node", int(GltfAvatar::hidden)}, {"index", 0}, {"weight", 1}};
  avatar.json["extensions"]["VRMC_vrm"]["expressions"] = {
      {"preset", {{"aa", {{"morphTargetBinds", {jaw, teeth, tongue}}, {"overrideBlink", "block"}}}}},
      {"custom", {{"gone", {{"morphTargetBinds", {nothing}}}}}}};
  const auto rig = open_vrm(avatar);
  CHECK(control_names(*rig) == std::vector<std::string>{"jawOpen", "browInnerUp", "mouthSmileLeft", "tongueOut", "aa"});
  check_same(points_of(*rig, {{"aa", 1}}), avatar.points({{"jawOpen", 0.5}}));
  CHECK(contains(notes_of(*rig), "what expressions override is left out: \"aa\""));
  CHECK(contains(notes_of(*rig), "parts of expressions that name no morph target are left out: \"gone\""));
}

TEST_CASE("whatever is no expression is none") {
  for (const char* text : {"3", "{}", "{\"blendShapeMaster\":{\"blendShapeGroups\":{}}}",
                           "{\"blendShapeMaster\":{\"blendShapeGroups\":[1,{\"binds\":2},{\"binds\":[3,{}]}]}}"}) {
    GltfAvatar avatar;
    avatar.json["extensions"]["VRM"] = json::parse(text);
    CHECK(control_names(*open_vrm(avatar)).size() == 4);
  }
}

}  // namespace test_gltf_expressions
