// Whole characters from glTF files: several meshes with shared morph targets, skins, materials and images.
#include <cmath>
#include <fstream>
#include <functional>

#include "archive/reader.h"
#include "bake/measure/verify.h"
#include "bake/pipeline/bake.h"
#include "bake/rig/gltf/gltf_rig.h"
#include "bake/rig_process/rig_messages.h"
#include "bake_test_support.h"
#include "gltf_avatar.h"
#include "skinning.h"

namespace test_gltf_avatar {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;
using nlohmann::json;

namespace {

OpenedSource open(const std::string& bytes) {
  return open_gltf_rig(std::as_bytes(std::span(bytes)), "avatar");
}
OpenedSource open(const GltfAvatar& avatar) {
  return open(avatar.glb());
}

std::string notes_of(const Source& rig) {
  std::string all;
  for (const std::string& note : rig.notes()) all += note + "\n";
  return all;
}

std::vector<float> pose_of(const Source& rig, const std::map<std::string, double>& weights) {
  std::vector<float> pose = rig.schema().rest_pose();
  for (const auto& [name, weight] : weights) pose.at(rig.schema().find(name).value()) = static_cast<float>(weight);
  return pose;
}

// Points of a pose, skinned by the joints as they are at rest.
std::vector<double> skinned_points(Source& rig, const std::map<std::string, double>& weights) {
  std::vector<float> points(rig.rest().points.size());
  rig.evaluate(pose_of(rig, weights), 1, points);
  return skinned(rig.character(), joint_places(rig.character()), points);
}

void check_posed(Source& rig, const GltfAvatar& avatar, const std::map<std::string, double>& weights) {
  const std::vector<double> points = skinned_points(rig, weights), expected = avatar.points(weights);
  REQUIRE(points.size() == expected.size());
  double worst = 0;
  for (std::size_t i = 0; i < points.size(); ++i) worst = std::max(worst, std::abs(points[i] - expected[i]));
  CHECK(worst < 2e-6);
}

std::vector<std::byte> bytes_of(const std::vector<std::uint8_t>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  return {bytes.begin(), bytes.end()};
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
  static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) { return i + k < bytes.size() ? std::uint32_t(bytes[i + k]) : 0u; };
    const std::uint32_t three = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (int shift = 18; shift >= 0; shift -= 6) text += digits[three >> shift & 63];
  }
  const std::size_t padding = (3 - bytes.size() % 3) % 3;
  return text.replace(text.size() - padding, padding, padding, '=');
}

void check_refused(const std::function<void(GltfAvatar&)>& change, Status status, const std::string& message) {
  GltfAvatar avatar;
  change(avatar);
  const std::string what = failure(status, [&] { open(avatar); });
  CHECK_MESSAGE(contains(what, message), what);
}

}  // namespace

TEST_CASE("all meshes of the scene are parts of one rig, placed by nodes and joints") {
  const GltfAvatar avatar;
  const auto rig = open(avatar);
  const Mesh& rest = rig->rest();
  CHECK(rig->schema().name == "avatar");
  CHECK(rig->schema().units == "m");
  REQUIRE(rest.parts.size() == 5);
  std::size_t vertex = 0, corner = 0;
  for (std::size_t p = 0; p < 5; ++p) {
    const GltfAvatar::Part& part = avatar.parts[p];
    CAPTURE(part.name);
    CHECK(rest.parts[p].name == part.name);
    CHECK(rest.parts[p].vertices == part.points.size() / 3);
    CHECK(rest.parts[p].polygons == part.triangles.size() / 3);
    for (std::size_t i = 0; i < part.triangles.size(); ++i, ++corner) {
      CHECK(rest.polygon_corners[corner] == vertex + part.triangles[i]);
      const std::size_t pair = 2 * std::size_t(rest.uv_corners[corner]);
      const bool known = !part.uvs.empty();
      CHECK(rest.uvs[pair] == (known ? part.uvs[2 * part.triangles[i]] : 0));
      CHECK(rest.uvs[pair + 1] == (known ? 1 - part.uvs[2 * part.triangles[i] + 1] : 0));
    }
    vertex += part.points.size() / 3;
  }
  CHECK(corner == rest.polygon_corners.size());
  CHECK(rest.polygon_sizes == std::vector<std::uint32_t>(corner / 3, 3));
  check_posed(*rig, avatar, {});
  CHECK(contains(notes_of(*rig), "some texture coordinates are missing, and 0: \"EyeLeft\", \"EyeRight\"\n"));
}

TEST_CASE("morph targets of one name are one control of several meshes") {
  const GltfAvatar avatar;
  const auto rig = open(avatar);
  std::vector<std::string> names;
  for (const Control& control : rig->schema().controls) names.push_back(control.name);
  CHECK(names == std::vector<std::string>{"jawOpen", "browInnerUp", "mouthSmileLeft", "tongueOut"});
  for (const std::string& name : names) check_posed(*rig, avatar, {{name, 1}});
  check_posed(*rig, avatar, {{"jawOpen", 0.5}, {"tongueOut", 0.25}, {"mouthSmileLeft", 1}, {"browInnerUp", 0.125}});
}

TEST_CASE("without names, targets are numbered, and told apart where meshes differ") {
  GltfAvatar avatar;
  avatar.json["meshes"][0].erase("extras");
  const auto one = open(avatar);
  CHECK(one->schema().find("target0"));
  CHECK(one->schema().find("jawOpen"));
  avatar.json["meshes"][3].erase("extras");
  const auto two = open(avatar);
  std::vector<std::string> names;
  for (const Control& control : two->schema().controls) names.push_back(control.name);
  CHECK(names == std::vector<std::string>{"Wolf3D_Head.target0", "Wolf3D_Head.target1", "Wolf3D_Head.target2",
                                          "jawOpen", "tongue.target0", "tongue.target1"});
  // Some exporters put names into the primitives.
  avatar.json["meshes"][0]["primitives"][0]["extras"]["targetNames"] = {"a", "b", "c"};
  CHECK((*open(avatar)).schema().controls[1].name == "b");
}

TEST_CASE("default weights of one control that differ are noted") {
  GltfAvatar avatar;
  avatar.json["meshes"][0]["weights"] = {0.5, 0, 0};
  const auto rig = open(avatar);
  CHECK(rig->schema().controls[0].rest == 0.5f);
  CHECK(contains(notes_of(*rig),
                 "default weights of one control differ between meshes, and the first is taken: "
                 "\"jawOpen\"\n"));
  std::vector<float> points(rig->rest().points.size());
  rig->evaluate(rig->schema().rest_pose(), 1, points);
  CHECK(points == rig->rest().points);
  avatar.json["nodes"][GltfAvatar::teeth_mesh]["weights"] = {0.5};
  avatar.json["nodes"][GltfAvatar::tongue_mesh]["weights"] = {0, 0.5};
  CHECK_FALSE(contains(notes_of(*open(avatar)), "differ"));
}

TEST_CASE("an animation of several meshes is one clip") {
  GltfAvatar avatar;
  const auto rig = open(avatar);
  REQUIRE(rig->clips().size() == 1);
  const Clip& clip = rig->clips()[0];
  CHECK(clip.name == "talk");
  REQUIRE(clip.frames == 10);
  for (std::size_t f = 0; f < 10; ++f) {
    CAPTURE(f);
    const double passed = std::min(double(f) / 6, 1.0);  // from the first to the last key of the head
    const double expected[] = {passed, 0.5 * passed, 0.25 * passed, f < 9 ? 0.0 : 1.0};
    for (std::size_t c = 0; c < 4; ++c) CHECK(clip.controls[4 * f + c] == doctest::Approx(expected[c]).epsilon(1e-5));
  }
  CHECK(contains(notes_of(*rig),
                 "animation \"talk\" moves controls otherwise in one mesh than in another, and the first is taken: "
                 "\"jawOpen\"\n"));
  CHECK(contains(notes_of(*rig), "what animations move besides weights is left out: \"talk\", \"nod\"\n"));
  // Head and teeth agree; without the tongue nothing is contested.
  avatar.json["animations"][0]["channels"].erase(2);
  CHECK_FALSE(contains(notes_of(*open(avatar)), "otherwise"));
}

TEST_CASE("cubic splines are sampled as glTF says") {
  GltfAvatar avatar;
  // In-tangents, value and out-tangents of two keys half a second apart, of the one target of the teeth.
  const std::vector<float> times = {1, 1.5f}, values = {9, 0.25f, 2, -1, 0.75f, 9};
  json sampler = {{"input", avatar.more().accessor(times, "SCALAR", 1)},
                  {"output", avatar.more().accessor(values, "SCALAR", 1)},
                  {"interpolation", "CUBICSPLINE"}};
  avatar.json["animations"] = json::array();
  avatar.json["animations"][0]["samplers"].push_back(sampler);
  avatar.json["animations"][0]["channels"].push_back(
      {{"sampler", 0}, {"target", {{"node", GltfAvatar::teeth_mesh}, {"path", "weights"}}}});
  const auto rig = open(avatar);
  REQUIRE(rig->clips().size() == 1);
  CHECK(rig->clips()[0].name == "animation0");
  REQUIRE(rig->clips()[0].frames == 16);
  for (std::size_t f = 0; f < 16; ++f) {
    // The cubic polynomial with these values and slopes at its ends, by Horner's rule.
    const double t = double(f) / 15, p0 = 0.25, p1 = 0.75, m0 = 0.5 * 2, m1 = 0.5 * -1;
    const double expected = p0 + t * (m0 + t * (3 * (p1 - p0) - 2 * m0 - m1 + t * (2 * (p0 - p1) + m0 + m1)));
    CHECK(rig->clips()[0].controls[4 * f] == doctest::Approx(expected).epsilon(1e-5));
  }
}

TEST_CASE("materials that are used are read with their images, byte for byte") {
  GltfAvatar avatar;
  avatar.json["materials"][2]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 4;
  const auto rig = open(avatar);
  const std::vector<MeshPart>& parts = rig->rest().parts;
  CHECK(parts[0].materials == std::vector<MaterialRun>{{40, 0}, {4, 1}});
  CHECK(parts[1].materials == std::vector<MaterialRun>{{8, no_material}});
  CHECK(parts[3].materials == std::vector<MaterialRun>{{6, 2}});
  CHECK(parts[4].materials == std::vector<MaterialRun>{{8, 2}});
  Character expected;
  Material& skin = expected.materials.emplace_back();
  skin.name = "Wolf3D_Skin";
  skin.base_colour = {1, 0.5f, 0.25f, 1};
  skin.metallic = 0;
  skin.roughness = 0.75f;
  skin.double_sided = true;
  skin.textures = {{TextureSlot::base_colour, 0, Wrap::clamp, Wrap::mirror, 1},
                   {TextureSlot::normal, 1, Wrap::repeat, Wrap::repeat, 0.5f},
                   {TextureSlot::occlusion, 0, Wrap::clamp, Wrap::mirror, 0.25f}};
  Material& brows = expected.materials.emplace_back();
  brows.name = "Wolf3D_Brows";
  brows.alpha_mode = AlphaMode::mask;
  brows.alpha_cutoff = 0.25f;
  brows.emissive = {0, 2, 4};
  Material& teeth = expected.materials.emplace_back();
  teeth.name = "Wolf3D_Teeth";
  teeth.metallic = 0;
  expected.images = {{"skin", "image/png", bytes_of(skin_png)}, {"normals", "image/png", bytes_of(normal_png)}};
  CHECK(rig->character().materials == expected.materials);
  CHECK(rig->character().images == expected.images);
}

TEST_CASE("images are in buffer views, data URIs and compressed forms") {
  std::vector<std::uint8_t> ktx2 = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n', 1, 2, 3};
  std::vector<std::uint8_t> webp = {'R', 'I', 'F', 'F', 9, 0, 0, 0, 'W', 'E', 'B', 'P', 7};
  GltfAvatar avatar;
  json& images = avatar.json["images"];
  images[1] = {{"uri", "data:image/png;base64," + base64(skin_png)}};
  images[2] = {{"uri", "data:image/webp;base64," + base64(webp)}};
  images.push_back({{"bufferView", avatar.more().view(ktx2.data(), ktx2.size())}, {"mimeType", "image/ktx2"}});
  avatar.json["textures"][1] = {{"extensions", {{"EXT_texture_webp", {{"source", 2}}}}}};
  avatar.json["materials"][2]["emissiveTexture"]["index"] = 2;
  avatar.json["textures"].push_back({{"source", 0}, {"extensions", {{"KHR_texture_basisu", {{"source", 3}}}}}});
  avatar.json["extensionsRequired"] = {"KHR_texture_basisu"};
  const auto rig = open(avatar);
  REQUIRE(rig->character().images.size() == 3);
  CHECK(rig->character().images[0] == Image{"", "image/png", bytes_of(skin_png)});
  CHECK(rig->character().images[1] == Image{"", "image/webp", bytes_of(webp)});
  CHECK(rig->character().images[2] == Image{"", "image/ktx2", bytes_of(ktx2)});
  CHECK(rig->character().materials[1].textures ==
        std::vector<Texture>{{TextureSlot::emissive, 2, Wrap::repeat, Wrap::repeat, 1}});
}

TEST_CASE("what is dropped from materials and meshes is named in notes") {
  GltfAvatar avatar;
  json& skin = avatar.json["materials"][1];
  skin["extensions"] = {{"KHR_materials_specular", {{"specularFactor", 0.5}}}, {"KHR_materials_unlit", json::object()}};
  skin["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {{"scale", {2, 2}}};
  skin["occlusionTexture"]["texCoord"] = 1;
  avatar.json["materials"][3]["emissiveTexture"]["index"] = 2;
  avatar.json["textures"].push_back(json::object());
  avatar.json["images"][2]["bufferView"] = 0;
  avatar.json["bufferViews"][0]["byteOffset"] = 4;  // no longer the beginning of a PNG
  avatar.json["meshes"][2]["primitives"][0]["attributes"]["COLOR_0"] = 0;
  const auto rig = open(avatar);
  for (const char* note :
       {"the extension KHR_materials_specular of materials is left out: \"Wolf3D_Skin\"\n",
        "the extension KHR_materials_unlit of materials is left out: \"Wolf3D_Skin\"\n",
        "KHR_texture_transform is left out, of materials: \"Wolf3D_Skin\"\n",
        "textures that use other texture coordinates than the first are left out, of materials: \"Wolf3D_Skin\"\n",
        "textures without an image are left out, of materials: \"Wolf3D_Teeth\"\n",
        "images that are no PNG, JPEG, KTX2 or WebP are left out: \"skin\", \"normals\"\n",
        "vertex colours are left out: \"teeth\"\n"})
    CHECK_MESSAGE(contains(notes_of(*rig), note), note << " is not in\n" << notes_of(*rig));
  CHECK(rig->character().images.empty());
  CHECK(rig->character().materials[0].textures.empty());
  // A transform that does nothing is not worth a note.
  skin["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {
      {"offset", {0, 0}}, {"rotation", 0}, {"scale", {1, 1}}};
  CHECK_FALSE(contains(notes_of(*open(avatar)), "KHR_texture_transform"));
}

TEST_CASE("a placement that all textures of a material have goes into the texture coordinates") {
  // Here those of the head, and not of its brows.
  GltfAvatar avatar;
  json& skin = avatar.json["materials"][1];
  const json transform = {{"offset", {0.25, 0.5}}, {"scale", {2, 4}}};
  skin["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = transform;
  skin["normalTexture"]["extensions"]["KHR_texture_transform"] = transform;
  skin["occlusionTexture"]["extensions"]["KHR_texture_transform"] = transform;
  const auto placed = open(avatar);
  CHECK_FALSE(contains(notes_of(*placed), "KHR_texture_transform"));
  const GltfAvatar::Part& head = avatar.parts[0];
  for (std::size_t i = 0; i < head.triangles.size(); ++i) {
    const std::size_t v = head.triangles[i], pair = 2 * std::size_t(placed->rest().uv_corners[i]);
    const bool brow = v >= 30;
    CHECK(placed->rest().uvs[pair] == (brow ? head.uvs[2 * v] : 0.25f + 2 * head.uvs[2 * v]));
    CHECK(placed->rest().uvs[pair + 1] == 1 - (brow ? head.uvs[2 * v + 1] : 0.5f + 4 * head.uvs[2 * v + 1]));
  }
  // Primitives that share vertices, and place textures otherwise, have coordinates of their own.
  json& primitives = avatar.json["meshes"][0]["primitives"];
  json again = primitives[0];
  again["material"] = 2;
  primitives.push_back(again);
  const auto twice = open(avatar);
  CHECK(twice->rest().points.size() == placed->rest().points.size());
  const std::size_t first = head.triangles.size(), shared = twice->rest().parts[0].materials[0].polygons;
  for (std::size_t i = 0; i < 3 * shared; ++i) {
    const std::size_t v = head.triangles[i], pair = 2 * std::size_t(twice->rest().uv_corners[first + i]);
    CHECK(twice->rest().polygon_corners[first + i] == v);
    CHECK(twice->rest().uvs[pair] == head.uvs[2 * v]);
  }
}

TEST_CASE("buffers and images may lie beside a file, and nowhere else") {
  const Folder folder;
  std::filesystem::create_directories(folder / "textures");
  const auto put = [&](const char* name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
  };
  GltfAvatar avatar;
  avatar.json["buffers"][0]["uri"] = "avatar%201.bin";
  avatar.json["images"][1] = {{"uri", "textures/skin.png"}};
  put("avatar 1.bin", avatar.buffer());
  put("textures/skin.png", std::string(skin_png.begin(), skin_png.end()));
  const auto open_written = [&] {
    put("avatar.gltf", avatar.json.dump());
    return open_source(folder / "avatar.gltf");
  };
  const auto rig = open_written();
  check_posed(*rig, avatar, {{"jawOpen", 1}});
  CHECK(rig->character().images[0] == Image{"skin.png", "image/png", bytes_of(skin_png)});
  CHECK(rig->version() == (*open(GltfAvatar())).version());

  // What deforms decides what rig it is, wherever it lies.
  std::string changed = avatar.buffer();
  changed[200] = static_cast<char>(changed[200] ^ 1);
  put("avatar 1.bin", changed);
  CHECK((*open_written()).version() != rig->version());

  std::filesystem::create_directories(folder / "inner/textures");
  put("inner/avatar 1.bin", avatar.buffer());
  const auto with_outside = [&](const char* list, std::size_t index, const std::string& name, const auto& check) {
    std::filesystem::create_symlink(folder / name, folder / "inner" / ("link " + name));
    for (const std::string& uri : {"../" + name, "%2e%2e/" + name, (folder / name).string(), "link " + name}) {
      CAPTURE(uri);
      json changed = avatar.json;
      changed[list][index]["uri"] = uri;
      std::ofstream(folder / "inner/avatar.gltf") << changed.dump();
      check();
    }
  };
  put("secret.png", std::string(skin_png.begin(), skin_png.end()));
  with_outside("images", 1, "secret.png", [&] {
    const auto without = open_source(folder / "inner/avatar.gltf");
    CHECK(contains(notes_of(*without), "which does not lie in its folder"));
    for (const Image& image : without->character().images) CHECK(image.bytes != bytes_of(skin_png));
  });
  put("inner/textures/skin.png", std::string(skin_png.begin(), skin_png.end()));
  put("secret.bin", avatar.buffer());
  with_outside("buffers", 0, "secret.bin", [&] {
    CHECK(contains(failure(Status::bad_data, [&] { open_source(folder / "inner/avatar.gltf"); }),
                   "which does not lie in its folder"));
  });
  for (const auto& [uri, message] : {std::pair{"missing.png", "missing.png"},
                                     {"https://example.org/skin.png", "which is no file beside it"},
                                     {"data:image/png,plain", "a data URI is not base64"},
                                     {"data:image/webp;base64,!", "a character that is no base64"}}) {
    avatar.json["images"][1]["uri"] = uri;
    const auto without = open_written();
    CHECK_MESSAGE(contains(notes_of(*without), message), notes_of(*without));
  }
  avatar.json["images"] = GltfAvatar().json["images"];
  avatar.json["buffers"][0]["uri"] = "../avatar.bin";
  CHECK(contains(failure(Status::bad_data, [&] { open_written(); }), "which does not lie in its folder"));
  avatar.json["buffers"][0]["uri"] = "none.bin";
  CHECK(contains(failure(Status::not_found, [&] { open_written(); }), "none.bin"));
  // In memory there is nothing beside.
  CHECK(contains(failure(Status::bad_data, [&] { open(avatar.json.dump()); }), "other files are not read here"));
}

TEST_CASE("quantised positions, targets and texture coordinates are read") {
  GltfAvatar avatar;
  json& tongue = avatar.json["meshes"][3]["primitives"][0];
  GltfAvatar::Part& part = avatar.parts[4];
  const auto quantised = [&](std::vector<float>& values, float steps) {
    std::vector<std::int16_t> whole;
    for (float& x : values) {
      whole.push_back(static_cast<std::int16_t>(std::lround(x * steps)));
      x = static_cast<float>(whole.back()) / (steps == 256 ? 1 : 32767.0f);
    }
    return whole;
  };
  const auto normalised = [&](int accessor) {
    avatar.json["accessors"][static_cast<std::size_t>(accessor)]["normalized"] = true;
    return accessor;
  };
  tongue["attributes"]["POSITION"] = avatar.more().accessor(quantised(part.points, 256), "VEC3", 3);
  tongue["attributes"]["TEXCOORD_0"] = normalised(avatar.more().accessor(quantised(part.uvs, 32767), "VEC2", 2));
  tongue["targets"][0]["POSITION"] =
      normalised(avatar.more().accessor(quantised(part.targets["tongueOut"], 32767), "VEC3", 3));
  avatar.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const auto rig = open(avatar);
  std::vector<float> points(rig->rest().points.size());
  rig->evaluate(pose_of(*rig, {{"tongueOut", 1}}), 1, points);
  const std::vector<double> expected = avatar.points({{"tongueOut", 1}});
  for (std::size_t i = points.size() - 27; i < points.size(); ++i)
    CHECK(points[i] == doctest::Approx(expected[i]).epsilon(1e-5));
  CHECK(rig->rest().uvs[rig->rest().uvs.size() - 4] == part.uvs[16]);
}

TEST_CASE("strips, fans, points and primitives that share vertices") {
  GltfAvatar avatar;
  json& primitives = avatar.json["meshes"][3]["primitives"];
  const auto with = [&](int mode, const std::vector<std::uint16_t>& corners) {
    json primitive = primitives[0];
    primitive["mode"] = mode;
    primitive["indices"] = avatar.more().accessor(corners, "SCALAR", 1);
    return primitive;
  };
  const json list = primitives[0];
  primitives = {list, with(5, {0, 1, 2, 3, 4}), with(6, {0, 1, 2, 3}), with(0, {0, 1}), with(3, {0, 1})};
  json unindexed = list;
  unindexed.erase("indices");
  unindexed["attributes"].erase("TEXCOORD_0");
  primitives.push_back(unindexed);
  const auto rig = open(avatar);
  const MeshPart& part = rig->rest().parts[4];
  CHECK(part.vertices == 18);  // those of the first, which three primitives share, and of the last
  CHECK(part.materials == std::vector<MaterialRun>{{8, 2}, {3, 2}, {2, 2}, {3, 2}});
  const std::vector<std::uint32_t>& corners = rig->rest().polygon_corners;
  const auto first = static_cast<std::uint32_t>(rig->rest().vertex_count() - 18);
  std::vector<std::uint32_t> last(corners.end() - 3 * 8, corners.end());
  for (std::uint32_t& corner : last) corner -= first;
  CHECK(last == std::vector<std::uint32_t>{0, 1,  2,  1,  3,  2,  2,  3,  4, 1, 2, 0, 2, 3, 0,  //
                                           9, 10, 11, 12, 13, 14, 15, 16, 17});
  CHECK(contains(notes_of(*rig), "points and lines are left out: \"tongue\"\n"));
}

TEST_CASE("nodes without names, equal names, and files without a scene") {
  GltfAvatar avatar;
  avatar.json["nodes"][GltfAvatar::right_eye]["name"] = "EyeLeft";
  CHECK((*open(avatar)).rest().parts[2].name == "EyeLeft (2)");
  avatar.json.erase("scene");
  const auto all = open(avatar);
  REQUIRE(all->rest().parts.size() == 6);
  CHECK(all->rest().parts[5].name == "Hidden");
  avatar.json.erase("nodes");
  avatar.json.erase("animations");
  avatar.json.erase("skins");
  const auto bare = open(avatar);  // every mesh where it is
  REQUIRE(bare->rest().parts.size() == 4);
  CHECK(bare->rest().parts[0].name == "head");
  for (std::size_t i = 0; i < avatar.parts[0].points.size(); ++i)
    CHECK(bare->rest().points[i] == avatar.parts[0].points[i]);
}

TEST_CASE("a skin without inverse bind matrices, and vertices without weights, are read") {
  GltfAvatar avatar;
  avatar.json["skins"][0].erase("inverseBindMatrices");
  json& teeth = avatar.json["meshes"][2]["primitives"][0]["attributes"];
  teeth["WEIGHTS_0"] = avatar.more().accessor(std::vector<float>(32, 0), "VEC4", 4);
  const auto rig = open(avatar);
  const std::size_t first = rig->rest().vertex_count() - 9 - 8;
  // They follow their first joint, the neck: twice as large, turned by 30 degrees, one and a half up and doubled.
  const GltfAvatar::Part& part = avatar.parts[3];
  const double c = std::sqrt(0.75), s = 0.5;
  const std::vector<double> points = skinned_points(*rig, {});
  for (std::size_t v = 0; v < 8; ++v) {
    const double x = double(part.points[3 * v]), y = double(part.points[3 * v + 1]);
    CHECK(points[3 * (first + v)] == doctest::Approx(2 * (c * x - s * y)).epsilon(1e-5));
    CHECK(points[3 * (first + v) + 1] == doctest::Approx(0.5 + 2 * (1 + s * x + c * y)).epsilon(1e-5));
  }
}

TEST_CASE("a rig in a child process tells the notes of a file") {
  GltfAvatar avatar;
  const auto rig = open(avatar);
  const RigDescription told = description_of(hello_answer(*rig));
  CHECK(told.notes == rig->notes());
  CHECK(told.character == rig->character());
}

TEST_CASE("files that contradict themselves are refused by name") {
  using Avatar = GltfAvatar;
  const auto bad = [](const std::function<void(Avatar&)>& change, const char* message) {
    check_refused(change, Status::bad_data, message);
  };
  bad([](Avatar& a) { a.json["nodes"][Avatar::head]["children"] = {Avatar::armature}; }, "are their own parents");
  bad([](Avatar& a) { a.json["nodes"][Avatar::armature]["children"] = {Avatar::armature}; }, "are their own parents");
  bad(
      [](Avatar& a) {
        a.json["nodes"][Avatar::neck]["children"] = {Avatar::head, Avatar::left_eye};
      },
      "node 4 has two parents, 1 and 2");
  bad([](Avatar& a) { a.json["nodes"][Avatar::neck]["children"] = {99}; }, "node 1 has the child 99 of 9 nodes");
  bad([](Avatar& a) { a.json["scene"] = 3; }, "its scene is 3 of 1");
  bad([](Avatar& a) { a.json["scenes"][0]["nodes"] = {-2}; }, "its scene names node -2 of 9");
  bad(
      [](Avatar& a) {
        a.json["scenes"][0]["nodes"] = {Avatar::left_eye};
        a.json.erase("animations");
      },
      "shows no mesh with morph targets");
  bad([](Avatar& a) { a.json["nodes"][Avatar::left_eye]["mesh"] = 4; }, "node 4 names mesh 4 of 4");
  bad([](Avatar& a) { a.json["nodes"][Avatar::head_mesh]["skin"] = 1; }, "node 3 names skin 1 of 1");
  bad([](Avatar& a) { a.json["skins"][0]["joints"] = {1, 99}; }, "mesh \"Wolf3D_Head\": its skin names node 99 of 9");
  bad([](Avatar& a) { a.json["skins"][0]["joints"] = {1}; }, "of its joints is 1 of 1");
  bad([](Avatar& a) { a.json["skins"][0]["joints"] = {1, 2, 2}; }, "2 inverse bind matrices for 3 joints");
  bad([](Avatar& a) { a.json["meshes"][0]["primitives"][0]["mode"] = 7; }, "the unknown mode 7");
  bad([](Avatar& a) { a.json["images"][1]["bufferView"] = 999; }, "is no whole glTF file");
  bad([](Avatar& a) { a.json["animations"][0]["samplers"][0]["interpolation"] = "CUBICSPLINE"; },
      "has 6 key weights where 18 are needed");
  bad([](Avatar& a) { a.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 999; },
      "no accessor 999 for its positions");
  check_refused([](Avatar& a) { a.json["extensionsRequired"] = {"EXT_unheard_of"}; }, Status::unsupported,
                "requires the glTF extension EXT_unheard_of");
}

TEST_CASE("a bake of an avatar has its meshes, materials and images") {
  for (const char* recipe : {"linear", "compact"}) {
    const GltfAvatar avatar;
    const auto rig = open(avatar);
    const Folder folder;
    BakeOptions options;
    options.recipe = recipe;
    options.poses = 200;
    options.epochs = 2;
    options.work = folder.path();
    const Baked baked = bake_face(*rig, options, silent_progress());
    const archive::Archive archive = archive::read_archive(baked.archive);
    CHECK(archive.model.rest.parts == rig->rest().parts);
    CHECK(archive.model.character == rig->character());
    CHECK(archive.model.schema.controls.size() == 4);
    CHECK(verify_archive(baked.archive).poses > 0);
  }
}

TEST_CASE("another image in the file is another bake in the same folder") {
  GltfAvatar avatar;
  const Folder folder;
  const auto bake = [&] {
    const auto rig = open(avatar);
    BakeOptions options;
    options.recipe = "linear";
    options.poses = 50;
    options.work = folder.path();
    return archive::read_archive(bake_face(*rig, options, silent_progress()).archive).model.character.images;
  };
  CHECK(bake()[0].bytes == bytes_of(skin_png));
  avatar.json["images"][1]["bufferView"] = 1;
  CHECK(bake()[0].bytes == bytes_of(normal_png));
}

}  // namespace test_gltf_avatar
