// Joints and skins of glTF files: whatever poses a skeleton is in, points before skinning, skinned by the joints that
// were read, are what the file shows by the rules of glTF.
#include <fstream>
#include <functional>

#include "bake/rig/gltf/gltf_rig.h"
#include "bake_test_support.h"
#include "gltf_body.h"
#include "gltf_posing.h"

namespace test_gltf_skins {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;
using nlohmann::json;

namespace {

OpenedSource open_bytes(const std::string& bytes) {
  return open_gltf_rig(std::as_bytes(std::span(bytes)), "body");
}

// Some places of nodes, and weights.
GltfPose some_pose(const std::vector<std::string>& nodes, const RigSchema& schema, double seed) {
  GltfPose pose;
  for (const std::string& name : nodes) {
    seed += 0.7;
    pose.locals[name] = GltfBody::matrix(
        {{std::sin(seed), 2 * std::cos(seed), seed / 9}, {0.6, 0, 0.8}, seed, 1 + 0.25 * std::sin(seed)});
  }
  for (const Control& control : schema.controls) pose.weights[control.name] = 0.5 + 0.5 * std::sin(seed += 1);
  return pose;
}

// Compares a file in some poses of these nodes, and as it is.
OpenedSource check_skinned(const std::string& glb, const std::vector<std::string>& nodes) {
  const Folder folder;
  std::ofstream(folder / "file.glb", std::ios::binary) << glb;
  const tinygltf::Model model = load_glb((folder / "file.glb").string());
  OpenedSource rig = open_bytes(glb);
  for (int p = 0; p < 6; ++p) {
    const GltfPose pose = p == 0 ? GltfPose{} : some_pose(nodes, rig->schema(), 10 * p);
    std::vector<float> controls = rig->schema().rest_pose(), points(rig->rest().points.size());
    for (const auto& [name, weight] : pose.weights)
      controls.at(rig->schema().find(name).value()) = static_cast<float>(weight);
    rig->evaluate(controls, 1, points);
    const std::vector<double> found = skinned(rig->character(), joint_places(rig->character(), pose.locals), points);
    CAPTURE(p);
    CHECK(largest_distance(found, posed_points(model, pose)) < 1e-5);
  }
  return rig;
}

std::vector<std::string> joint_names(const Source& rig) {
  std::vector<std::string> names;
  for (const Joint& joint : rig.character().joints) names.push_back(joint.name);
  return names;
}

const std::vector<std::string> body_joints = {"Armature", "Hips", "Spine", "Neck", "Head", "EyeJoint"};
const std::vector<std::string> avatar_joints = {"Armature", "Neck", "Head"};

}  // namespace

TEST_CASE("two skins of one skeleton and a mesh on a joint are skinned in one space") {
  const GltfBody body;
  const auto rig = check_skinned(body.glb(), body_joints);
  CHECK(joint_names(*rig) == body_joints);
  const std::vector<Joint>& joints = rig->character().joints;
  CHECK(joints[0].parent == no_joint);
  for (std::size_t j = 1; j < joints.size(); ++j) CHECK(joints[j].parent == j - 1);
  // The eye follows its joint alone.
  const Skin& skin = rig->character().skin;
  const std::size_t last = rig->rest().vertex_count() - 1;
  CHECK(skin.influences == 2);
  CHECK(skin.joints[2 * last] == 5);
  CHECK(skin.weights[2 * last] == 1);
  CHECK(skin.weights[2 * last + 1] == 0);
}

TEST_CASE("a file that shows a face as it was bound has its points where the file shows them") {
  GltfBody body;
  for (std::size_t n = 0; n <= GltfBody::eye_joint; ++n) {
    const GltfBody::Local bound = GltfBody::local(n, 0);
    const double s = std::sin(bound.angle / 2);
    body.json["nodes"][n]["translation"] = bound.move;
    body.json["nodes"][n]["rotation"] = {s * bound.axis[0], s * bound.axis[1], s * bound.axis[2],
                                         std::cos(bound.angle / 2)};
  }
  const auto rig = check_skinned(body.glb(), body_joints);
  const std::vector<double> shown = skinned(rig->character(), joint_places(rig->character()), rig->rest().points);
  CHECK(largest_distance({rig->rest().points.begin(), rig->rest().points.end()}, shown) < 1e-5);
}

TEST_CASE("an avatar in another pose than that of its binding is skinned in any other") {
  const GltfAvatar avatar;
  const auto rig = check_skinned(avatar.glb(), avatar_joints);
  CHECK(joint_names(*rig) == avatar_joints);
  CHECK(rig->character().skin.influences == 2);
}

TEST_CASE("a skin that was bound in another pose has joints of its own below those of the first") {
  GltfAvatar avatar;
  std::vector<float> inverses;
  for (int j = 0; j < 2; ++j)
    for (const double x : GltfBody::matrix({{0.5, 0.25 * j, 1}, {0, 1, 0}, 0.5 + j, 1.5})) inverses.push_back(float(x));
  avatar.json["skins"].push_back({{"joints", {GltfAvatar::head, GltfAvatar::neck}},
                                  {"inverseBindMatrices", avatar.more().accessor(inverses, "MAT4", 16)}});
  avatar.json["nodes"][GltfAvatar::teeth_mesh]["skin"] = 1;
  const auto rig = check_skinned(avatar.glb(), avatar_joints);
  REQUIRE(rig->character().joints.size() == 4);
  const Joint& own = rig->character().joints[3];
  CHECK((own.name == "Head (2)" || own.name == "Neck (2)"));
  CHECK(own.parent == (own.name == "Head (2)" ? 2 : 1));
  CHECK(own.rest == Frame<float>{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
}

TEST_CASE("eight influences, joints that a vertex names twice, and nodes without names") {
  GltfAvatar avatar;
  json& attributes = avatar.json["meshes"][0]["primitives"][0]["attributes"];
  const std::size_t vertices = 30;
  std::vector<std::uint8_t> joints;
  std::vector<float> first, second;
  for (std::size_t v = 0; v < vertices; ++v) {
    joints.insert(joints.end(), {1, 0, 0, 0});
    first.insert(first.end(), {0.125f, 0.5f, 0, 0});
    second.insert(second.end(), {0.125f, 0.25f, 0, 0});
  }
  const int of_joints = avatar.more().accessor(joints, "VEC4", 4);
  attributes["JOINTS_0"] = attributes["JOINTS_1"] = of_joints;
  attributes["WEIGHTS_0"] = avatar.more().accessor(first, "VEC4", 4);
  attributes["WEIGHTS_1"] = avatar.more().accessor(second, "VEC4", 4);
  avatar.json["nodes"][GltfAvatar::neck].erase("name");
  const auto rig = check_skinned(avatar.glb(), {"Armature", "Head"});
  CHECK(joint_names(*rig) == std::vector<std::string>{"Armature", "node1", "Head"});
  CHECK(rig->character().skin.influences == 2);
  CHECK(rig->character().skin.weights[0] == 0.25f);
  CHECK(rig->character().skin.weights[1] == 0.75f);
}

TEST_CASE("joints that were hidden by a scale of 0 are skinned by others") {
  GltfAvatar avatar;
  avatar.json["nodes"][GltfAvatar::head]["scale"] = {0, 0, 0};
  const auto rig = open_bytes(avatar.glb());
  CHECK(joint_names(*rig) == avatar_joints);
  avatar.json["nodes"][GltfAvatar::neck]["scale"] = {0, 0, 0};
  const std::string what = failure(Status::bad_data, [&] { open_bytes(avatar.glb()); });
  CHECK_MESSAGE(contains(what, "mesh \"Wolf3D_Head\": its skin has no joint whose matrices can be inverted"), what);
}

TEST_CASE("meshes on no joint follow none, and without skins there are no joints") {
  GltfAvatar avatar;
  avatar.json["nodes"].push_back({{"name", "Floor"}, {"mesh", 1}, {"translation", {0, 0, 4}}});
  avatar.json["scenes"][0]["nodes"].push_back(9);
  const auto rig = check_skinned(avatar.glb(), avatar_joints);
  CHECK(rig->rest().parts.back().name == "Floor");
  const Skin& skin = rig->character().skin;
  for (std::size_t v = rig->rest().vertex_count() - 9; v < rig->rest().vertex_count(); ++v) CHECK(skin.count(v) == 0);

  for (const auto node : {GltfAvatar::head_mesh, GltfAvatar::teeth_mesh}) avatar.json["nodes"][node].erase("skin");
  const auto rigid = open_bytes(avatar.glb());
  CHECK(rigid->character().joints.empty());
  CHECK(rigid->character().skin == Skin{});
}

}  // namespace test_gltf_skins
