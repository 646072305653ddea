// Parts of glTF files that are not as they should be: what viewers read is read, with notes, and the rest is left out
// where that is asked for.
#include <filesystem>
#include <fstream>
#include <functional>

#include "bake/rig/gltf/gltf_rig.h"
#include "bake_test_support.h"
#include "gltf_avatar.h"

namespace test_gltf_odd_parts {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

using Avatar = GltfAvatar;

OpenedSource open(const Avatar& avatar, const GltfOptions& options = {}) {
  const std::string bytes = avatar.glb();
  return open_gltf_rig(std::as_bytes(std::span(bytes)), "avatar", options);
}

std::string notes_of(const Source& rig) {
  std::string all;
  for (const std::string& note : rig.notes()) all += note + "\n";
  return all;
}

OpenedSource check_noted(const std::function<void(Avatar&)>& change, const std::string& note) {
  Avatar avatar;
  change(avatar);
  OpenedSource rig = open(avatar);
  CHECK_MESSAGE(contains(notes_of(*rig), note), note << " is not in\n" << notes_of(*rig));
  return rig;
}

const GltfOptions skipping = {JointUse::automatic, {}, true};

// A file beside which buffers lie, under any name.
std::string write_beside(const Folder& folder, const std::string& uri, const std::string& name) {
  Avatar avatar;
  avatar.json["buffers"][0]["uri"] = uri;
  std::ofstream(folder / "avatar.gltf") << avatar.json.dump();
  if (!name.empty()) std::ofstream(folder / name, std::ios::binary) << avatar.buffer();
  return folder / "avatar.gltf";
}

}  // namespace

TEST_CASE("what viewers read of meshes is read, with notes") {
  check_noted([](Avatar& a) { a.json["meshes"][0]["primitives"][1]["attributes"].erase("JOINTS_0"); },
              "some primitives of a mesh with a skin have no joints, and follow the first: \"head\"");
  check_noted([](Avatar& a) { a.json["meshes"][0]["primitives"][1].erase("targets"); },
              "fewer morph targets than others of their mesh, and do not move by the rest: \"head\"");
  const auto without =
      check_noted([](Avatar& a) { a.json["meshes"][0]["primitives"][1]["attributes"].erase("POSITION"); },
                  "primitives without positions are left out: \"head\"");
  CHECK(without->rest().parts[0].vertices == 30);
  Avatar corners;
  corners.json["meshes"][1]["primitives"][0].erase("indices");
  corners.json["meshes"][1]["primitives"][0]["attributes"]["POSITION"] =
      corners.more().accessor(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3", 3);
  CHECK((*open(corners)).rest().parts[1].polygons == 1);
}

TEST_CASE("joints that are not used need not exist") {
  Avatar avatar;
  avatar.json["meshes"][2]["primitives"][0]["attributes"]["JOINTS_0"] =
      avatar.more().accessor(std::vector<std::uint8_t>{0, 1, 99, 99, 0, 1, 99, 99, 0, 1, 99, 99, 0, 1, 99, 99,
                                                       0, 1, 99, 99, 0, 1, 99, 99, 0, 1, 99, 99, 0, 1, 99, 99},
                             "VEC4", 4);
  CHECK((*open(avatar)).character().skin == (*open(Avatar())).character().skin);
}

TEST_CASE("names and default weights of targets may be too few or too many") {
  const auto named = [](const nlohmann::json& names, const std::string& note) {
    return check_noted([&](Avatar& a) { a.json["meshes"][3]["extras"]["targetNames"] = names; }, note);
  };
  const auto more =
      named({"tongueOut", "jawOpen", "more"}, "holds more names than morph targets, and the first count: \"tongue\"");
  CHECK(more->schema().find("tongueOut"));
  const auto fewer = named({"tongueOut"}, "without a name are controls by their numbers: \"tongue target 1\"");
  CHECK(fewer->schema().find("tongue target 1"));
  const auto no_text = named({"tongueOut", 3}, "by their numbers: \"tongue target 1\"");
  CHECK(no_text->schema().find("tongue target 1"));
  const auto same = named({"tongue", "tongue"}, "told apart by numbers: \"tongue 2\"");
  CHECK(same->schema().find("tongue 2"));
  const auto weights = check_noted([](Avatar& a) { a.json["meshes"][3]["weights"] = {0.5}; },
                                   "the number of default weights is not that of morph targets");
  CHECK(weights->schema().controls[weights->schema().find("tongueOut").value()].rest == 0.5f);
}

TEST_CASE("names of targets that are taken are not given again") {
  Avatar avatar;
  avatar.json.erase("animations");
  auto& tongue = avatar.json["meshes"][3];
  auto& targets = tongue["primitives"][0]["targets"];
  targets.push_back(targets[0]);
  tongue["extras"]["targetNames"] = {"a", "a", "a 2"};
  const auto rig = open(avatar);
  for (const char* name : {"a", "a 2", "a 3"}) CHECK(rig->schema().find(name));
}

TEST_CASE("materials, textures and images that are not there are left out") {
  check_noted([](Avatar& a) { a.json["meshes"][0]["primitives"][0]["material"] = 9; },
              "materials that there are not are left out, of meshes: \"Wolf3D_Head\"");
  check_noted([](Avatar& a) { a.json["materials"][1]["normalTexture"]["index"] = 2; },
              "textures that there are not are left out, of materials: \"Wolf3D_Skin\"");
  check_noted([](Avatar& a) { a.json["materials"][2]["alphaMode"] = "GLASS"; },
              "unknown alpha modes are OPAQUE, of materials: \"Wolf3D_Brows\"");
  for (const char* way : {"sampler", "wrap"})
    check_noted(
        [&](Avatar& a) {
          if (way == std::string("sampler")) a.json["textures"][0]["sampler"] = 1;
          if (way == std::string("wrap")) a.json["samplers"][0]["wrapS"] = 1;
        },
        "unknown ways to wrap textures are to repeat them, of materials: \"Wolf3D_Skin\"");
  check_noted([](Avatar& a) { a.json["textures"][0]["source"] = 3; },
              "left out, as it cannot be read: a texture names image 3 of 3");
  check_noted([](Avatar& a) { a.json["bufferViews"][1]["byteLength"] = 1 << 20; },
              "left out, as it cannot be read: image 2 (\"normals\"): its bytes run past the end of their buffer");
  check_noted(
      [](Avatar& a) {
        a.json["images"][1] = {{"name", "skin"}, {"uri", "skin.png"}};
      },
      "left out, as it cannot be read: image 1 (\"skin\"): names \"skin.png\"; other files are not read here");
}

TEST_CASE("a mesh or an animation that cannot be read is left out if that is asked for") {
  const struct {
    std::function<void(Avatar&)> change;
    const char* reason;
    const char* mesh;  // that is left out; null: an animation is
  } parts[] = {
      {[](Avatar& a) { a.json["meshes"][2]["primitives"][0]["mode"] = 7; },
       "mesh \"Wolf3D_Teeth\": a primitive has the unknown mode 7", "Wolf3D_Teeth"},
      {[](Avatar& a) { a.json["meshes"][3]["primitives"][0]["targets"][0]["POSITION"] = 999; },
       "mesh \"tongue\": no accessor 999 for its moves of target 0", "tongue"},
      {[](Avatar& a) { a.json["meshes"][3]["primitives"][0]["attributes"]["POSITION"] = 999; },
       "mesh \"tongue\": no accessor 999 for its positions", "tongue"},
      {[](Avatar& a) { a.json["animations"][0]["samplers"][0]["interpolation"] = "CUBICSPLINE"; },
       "animation \"talk\": has 6 key weights where 18 are needed", nullptr},
      {[](Avatar& a) { a.json["animations"][0]["channels"][0]["sampler"] = 7; }, "animation \"talk\": has no sampler 7",
       nullptr},
  };
  for (const auto& part : parts) {
    CAPTURE(std::string(part.reason));
    Avatar avatar;
    part.change(avatar);
    CHECK(contains(failure(Status::bad_data, [&] { open(avatar); }), part.reason));
    const auto rig = open(avatar, skipping);
    CHECK_MESSAGE(contains(notes_of(*rig), std::string("left out, as it cannot be read: ") + part.reason),
                  notes_of(*rig));
    CHECK(rig->rest().parts.size() == (part.mesh ? 4u : 5u));
    for (const MeshPart& one : rig->rest().parts) CHECK(one.name != (part.mesh ? part.mesh : ""));
    CHECK(rig->clips().empty() == !part.mesh);
  }
  Avatar avatar;
  for (auto& mesh : avatar.json["meshes"]) mesh["primitives"][0]["mode"] = 7;
  CHECK(contains(failure(Status::bad_data, [&] { open(avatar, skipping); }), "none of its meshes can be read: mesh"));
}

TEST_CASE("animations by pointers to weights are read") {
  const auto weights_of = [](const std::string& pointer, const std::vector<float>& values) {
    Avatar avatar;
    const int times = avatar.more().accessor(std::vector<float>{0, 1.0f / 30}, "SCALAR", 1),
              output = avatar.more().accessor(values, "SCALAR", 1);
    avatar.json["extensionsUsed"] = {"KHR_animation_pointer"};
    avatar.json["animations"] = {
        {{"name", "point"},
         {"samplers", {{{"input", times}, {"output", output}}}},
         {"channels",
          {{{"sampler", 0},
            {"target", {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", pointer}}}}}}}}}}}};
    return open(avatar);
  };
  for (const char* pointer : {"/nodes/3/weights", "/meshes/0/weights"}) {
    const auto rig = weights_of(pointer, {0, 0, 0, 1, 0.5f, 0.25f});
    REQUIRE(rig->clips().size() == 1);
    const Clip& clip = rig->clips()[0];
    REQUIRE(clip.frames == 2);
    const std::size_t width = rig->schema().control_count();
    CHECK(clip.controls[width + rig->schema().find("jawOpen").value()] == 1);
    CHECK(clip.controls[width + rig->schema().find("browInnerUp").value()] == 0.5f);
    CHECK(clip.controls[width + rig->schema().find("mouthSmileLeft").value()] == 0.25f);
  }
  const auto one = weights_of("/nodes/3/weights/2", {0, 1});
  REQUIRE(one->clips().size() == 1);
  CHECK(one->clips()[0].controls[one->schema().control_count() + one->schema().find("mouthSmileLeft").value()] == 1);
  const auto other = weights_of("/materials/1/alphaCutoff", {0, 1});
  CHECK(other->clips().empty());
  CHECK(
      contains(notes_of(*other), "what KHR_animation_pointer moves besides weights and nodes is left out: \"point\""));
  CHECK((*weights_of("/nodes/3/weights/99", {0, 1})).clips().empty());
  CHECK((*weights_of("/nodes/99/weights", {0, 1})).clips().empty());
}

TEST_CASE("a percent sign in a URI is that of an encoding, or else a percent sign") {
  for (const auto& file : {std::pair("example 10%.bin", "example 10%.bin"),
                           {"a%20b.bin", "a b.bin"},
                           {"a%20b.bin", "a%20b.bin"},
                           {"10%25.bin", "10%.bin"},
                           {"a+b%2bc.bin", "a+b+c.bin"}}) {
    CAPTURE(std::string(file.second));
    const Folder folder;
    CHECK((*open_source(write_beside(folder, file.first, file.second))).schema().control_count() == 4);
  }
  const Folder folder;
  std::filesystem::create_directory(folder / "inside");
  Avatar avatar;
  std::ofstream(folder / "outside.bin", std::ios::binary) << avatar.buffer();
  for (const char* uri : {"../outside.bin", "%2e%2e/outside.bin", "..%2foutside.bin", "%2e%2e%2foutside.bin"}) {
    CAPTURE(std::string(uri));
    avatar.json["buffers"][0]["uri"] = uri;
    std::ofstream(folder / "inside/avatar.gltf") << avatar.json.dump();
    const std::string what = failure(Status::bad_data, [&] { open_source(folder / "inside/avatar.gltf"); });
    CHECK_MESSAGE(contains(what, "does not lie in its folder"), what);
  }
  CHECK(contains(failure(Status::not_found, [&] { open_source(write_beside(folder, "gone 5%.bin", "")); }),
                 "gone 5%.bin"));
}

TEST_CASE("extensions of files are told apart without regard to case") {
  const Folder folder;
  std::ofstream(folder / "AVATAR.GLB", std::ios::binary) << Avatar().glb();
  CHECK((*open_source(folder / "AVATAR.GLB")).schema().control_count() == 4);
}

TEST_CASE("what a node mirrors points the same way out as in its mesh") {
  // The eyes, a sheet each that bulges; on a mirrored joint, a mirrored node, and as a mirrored instance.
  const auto normal_z = [](const Source& rig, std::size_t part) {
    std::size_t corner = 0;
    for (std::size_t p = 0; p < part; ++p) corner += std::size_t{3} * rig.rest().parts[p].polygons;
    const auto at = [&](std::size_t k, std::size_t axis) {
      return double(rig.rest().points[std::size_t{3} * rig.rest().polygon_corners[corner + k] + axis]);
    };
    return (at(1, 0) - at(0, 0)) * (at(2, 1) - at(0, 1)) - (at(1, 1) - at(0, 1)) * (at(2, 0) - at(0, 0));
  };
  const double plain = normal_z(*open(Avatar()), 1);
  REQUIRE(plain > 0);
  for (const auto node : {Avatar::left_eye, Avatar::head, Avatar::armature}) {
    Avatar mirrored;
    mirrored.json["nodes"][node].erase("matrix");
    mirrored.json["nodes"][node]["scale"] = {-1, 1, 1};
    CAPTURE(int(node));
    CHECK(normal_z(*open(mirrored), 1) > 0);
    CHECK(normal_z(*open(mirrored, {JointUse::controls, {"Neck"}}), 1) > 0);
  }
  Avatar instanced;
  instanced.json["extensionsUsed"] = instanced.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  instanced.json["nodes"][Avatar::left_eye]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"SCALE", instanced.more().accessor(std::vector<float>{-1, 1, 1, 5, 5, 5}, "VEC3", 3)},
      {"TRANSLATION", instanced.more().accessor(std::vector<float>{0.5f, 0, 0, 9, 9, 9}, "VEC3", 3)}};
  const auto rig = open(instanced);
  CHECK(normal_z(*rig, 1) > 0);
  CHECK(rig->rest().parts[1].vertices == 9);
  CHECK(contains(notes_of(*rig), "the first instance is read, and others are left out: \"EyeLeft\""));
}

TEST_CASE("a skin whose joints mirror at rest turns its faces; the node of its mesh does not") {
  const auto first_z = [](const Source& rig) {
    const auto at = [&](std::size_t k, std::size_t axis) {
      return double(rig.rest().points[std::size_t{3} * rig.rest().polygon_corners[k] + axis]);
    };
    return (at(1, 0) - at(0, 0)) * (at(2, 1) - at(0, 1)) - (at(1, 1) - at(0, 1)) * (at(2, 0) - at(0, 0));
  };
  const double plain = first_z(*open(Avatar(), {JointUse::controls, {"Neck"}}));
  Avatar mirrored;
  mirrored.json["nodes"][Avatar::armature].erase("matrix");
  mirrored.json["nodes"][Avatar::armature]["scale"] = {-2, 2, 2};
  CHECK(plain * first_z(*open(mirrored, {JointUse::controls, {"Neck"}})) > 0);
  CHECK(plain * first_z(*open(mirrored)) > 0);
  Avatar of_mesh;
  of_mesh.json["nodes"][Avatar::head_mesh].erase("matrix");
  of_mesh.json["nodes"][Avatar::head_mesh]["scale"] = {-1, 1, 1};
  CHECK(plain * first_z(*open(of_mesh)) > 0);
}

}  // namespace test_gltf_odd_parts
