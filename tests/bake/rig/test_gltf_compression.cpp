// Geometry that files compress: EXT_meshopt_compression, KHR_draco_mesh_compression, quantised and sparse accessors.
#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <cmath>
#include <functional>

#include "bake/rig/gltf/gltf_rig.h"
#include "bake_test_support.h"
#include "gltf_avatar.h"
#include "skinning.h"

namespace test_gltf_compression {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;
using nlohmann::json;

namespace {

OpenedSource open_bytes(const std::string& bytes) {
  return open_gltf_rig(std::as_bytes(std::span(bytes)), "avatar");
}

// How far the rig's points of a pose, skinned by joints at rest, are from those of the avatar.
double largest_distance(Source& rig, const GltfAvatar& avatar, const std::map<std::string, double>& weights) {
  std::vector<float> pose = rig.schema().rest_pose(), points(rig.rest().points.size());
  for (const auto& [name, weight] : weights) pose.at(rig.schema().find(name).value()) = static_cast<float>(weight);
  rig.evaluate(pose, 1, points);
  const std::vector<double> found = skinned(rig.character(), joint_places(rig.character()), points),
                            expected = avatar.points(weights);
  REQUIRE(found.size() == expected.size());
  double worst = 0;
  for (std::size_t i = 0; i < found.size(); ++i) worst = std::max(worst, std::abs(found[i] - expected[i]));
  return worst;
}

std::size_t element_bytes(const json& accessor) {
  const std::map<std::string, std::size_t> widths = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
  const int component = accessor["componentType"];
  return widths.at(accessor["type"]) * (component >= 5125 ? 4 : component >= 5122 ? 2 : 1);
}

// An avatar whose accessors' views are compressed by meshoptimizer, in a binary file with a fallback buffer that has no
// data, as gltfpack and glTF-Transform write it.
class MeshoptAvatar {
 public:
  GltfAvatar avatar;
  json compressed;   // the JSON of the file
  std::string data;  // its buffer

  explicit MeshoptAvatar(const std::string& extension = "EXT_meshopt_compression") : compressed(avatar.json) {
    data = avatar.buffer();
    compressed["extensionsRequired"] = {extension};
    for (const json& accessor : avatar.json["accessors"]) compress(accessor, extension);
    compressed["buffers"] = {
        {{"byteLength", data.size()}},
        {{"byteLength", avatar.buffer().size()}, {"extensions", {{extension, {{"fallback", true}}}}}}};
  }
  std::string glb() const { return glb_file(compressed, data); }
  json& extension_of(std::size_t view) {
    return compressed["bufferViews"][view]["extensions"]["EXT_meshopt_compression"];
  }

 private:
  void compress(const json& accessor, const std::string& extension) {
    const std::size_t count = accessor["count"], stride = element_bytes(accessor), number = accessor["bufferView"];
    json& view = compressed["bufferViews"][number];
    const char* from = avatar.buffer().data() + std::size_t(view["byteOffset"]);
    const bool indices = accessor["componentType"] == 5123 && accessor["type"] == "SCALAR";
    if (!indices && stride % 4 != 0) return;
    std::vector<unsigned char> encoded(65536);
    if (indices) {
      std::vector<std::uint16_t> corners(count);
      std::memcpy(corners.data(), from, 2 * count);
      const std::vector<unsigned> wide(corners.begin(), corners.end());
      encoded.resize(meshopt_encodeIndexSequence(encoded.data(), encoded.size(), wide.data(), count));
    } else {
      encoded.resize(meshopt_encodeVertexBuffer(encoded.data(), encoded.size(), from, count, stride));
    }
    view["buffer"] = 1;
    view["extensions"][extension] = {{"buffer", 0},
                                     {"byteOffset", data.size()},
                                     {"byteLength", encoded.size()},
                                     {"byteStride", stride},
                                     {"count", count},
                                     {"mode", indices ? "INDICES" : "ATTRIBUTES"}};
    data.append(encoded.begin(), encoded.end());
  }
};

void check_meshopt_refused(const std::function<void(MeshoptAvatar&)>& change, Status status,
                           const std::string& message) {
  MeshoptAvatar made;
  change(made);
  const std::string what = failure(status, [&] { open_bytes(made.glb()); });
  CHECK_MESSAGE(contains(what, message), what);
}

// The view of an accessor of the avatar, by what a primitive of a mesh has it for.
std::size_t view_of(const json& file, std::size_t mesh, const std::string& attribute) {
  const json& primitive = file["meshes"][mesh]["primitives"][0];
  const std::size_t accessor = attribute == "indices" ? primitive["indices"] : primitive["attributes"][attribute];
  return file["accessors"][accessor]["bufferView"];
}

// Encodes a primitive of the avatar by Draco. `method`: of draco::MeshEncoderMethod; sequential keeps the order.
// `byte_type`: what bytes are said to be.
void compress_by_draco(GltfAvatar& avatar, std::size_t mesh, int method, draco::DataType byte_type = draco::DT_UINT8) {
  json& primitive = avatar.json["meshes"][mesh]["primitives"][0];
  const auto values = [&](std::size_t accessor) {
    const json& from = avatar.json["accessors"][accessor];
    return avatar.buffer().data() +
           std::size_t(avatar.json["bufferViews"][std::size_t(from["bufferView"])]["byteOffset"]);
  };
  const json& indices = avatar.json["accessors"][std::size_t(primitive["indices"])];
  const std::size_t corners = indices["count"],
                    points = avatar.json["accessors"][std::size_t(primitive["attributes"]["POSITION"])]["count"];
  draco::Mesh made;
  made.set_num_points(static_cast<std::uint32_t>(points));
  std::vector<std::uint16_t> of_corner(corners);
  std::memcpy(of_corner.data(), values(primitive["indices"]), 2 * corners);
  for (std::size_t f = 0; f < corners / 3; ++f)
    made.AddFace({draco::PointIndex(of_corner[3 * f]), draco::PointIndex(of_corner[3 * f + 1]),
                  draco::PointIndex(of_corner[3 * f + 2])});
  json ids;
  for (const auto& [name, index] : primitive["attributes"].items()) {
    json& accessor = avatar.json["accessors"][std::size_t(index)];
    const bool bytes = accessor["componentType"] == 5121;
    const int width = accessor["type"] == "VEC3" ? 3 : accessor["type"] == "VEC2" ? 2 : 4;
    draco::GeometryAttribute attribute;
    attribute.Init(name == "POSITION" ? draco::GeometryAttribute::POSITION : draco::GeometryAttribute::GENERIC, nullptr,
                   static_cast<std::uint8_t>(width), bytes ? byte_type : draco::DT_FLOAT32, false,
                   width * (bytes ? 1 : 4), 0);
    const int id = made.AddAttribute(attribute, true, static_cast<std::uint32_t>(points));
    for (std::size_t p = 0; p < points; ++p)
      made.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(p)),
                                            values(index) + p * element_bytes(accessor));
    ids[name] = made.attribute(id)->unique_id();
    accessor.erase("bufferView");
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  draco::EncoderBuffer encoded;
  REQUIRE(encoder.EncodeMeshToBuffer(made, &encoded).ok());
  primitive["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", avatar.more().view(encoded.data(), encoded.size())}, {"attributes", ids}};
  avatar.json["accessors"][std::size_t(primitive["indices"])].erase("bufferView");
  avatar.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
}

void check_draco_refused(const std::function<void(GltfAvatar&)>& change, Status status, const std::string& message) {
  GltfAvatar avatar;
  compress_by_draco(avatar, 2, draco::MESH_SEQUENTIAL_ENCODING);
  change(avatar);
  const std::string what = failure(status, [&] { open_bytes(avatar.glb()); });
  CHECK_MESSAGE(contains(what, message), what);
}

}  // namespace

TEST_CASE("views that meshoptimizer compresses are those that it was given") {
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const MeshoptAvatar made(extension);
    const auto rig = open_bytes(made.glb());
    const auto plain = open_bytes(made.avatar.glb());
    CHECK(rig->rest().points == plain->rest().points);
    CHECK(rig->rest().polygon_corners == plain->rest().polygon_corners);
    CHECK(rig->character().skin == plain->character().skin);
    CHECK(rig->clips().at(0).controls == plain->clips().at(0).controls);
    CHECK(rig->version() == plain->version());
    CHECK(largest_distance(*rig, made.avatar, {{"jawOpen", 0.5}, {"tongueOut", 1}}) < 2e-6);
  }
}

TEST_CASE("triangles and filtered values are decoded") {
  MeshoptAvatar made;
  // Triangles may come in another order of corners.
  const std::size_t triangles = view_of(made.avatar.json, 0, "indices");
  const std::size_t count = made.extension_of(triangles)["count"];
  std::vector<std::uint16_t> corners(count);
  std::memcpy(corners.data(),
              made.avatar.buffer().data() + std::size_t(made.avatar.json["bufferViews"][triangles]["byteOffset"]),
              2 * count);
  std::vector<unsigned> wide(corners.begin(), corners.end());
  std::vector<unsigned char> encoded(65536);
  encoded.resize(meshopt_encodeIndexBuffer(encoded.data(), encoded.size(), wide.data(), count));
  made.extension_of(triangles)["mode"] = "TRIANGLES";
  made.extension_of(triangles)["byteOffset"] = made.data.size();
  made.extension_of(triangles)["byteLength"] = encoded.size();
  made.data.append(encoded.begin(), encoded.end());
  // Positions as 2^exponent x mantissa: 24 bits of integers, so exact for eighths.
  const std::size_t positions = view_of(made.avatar.json, 3, "POSITION");
  const std::vector<float>& points = made.avatar.parts[4].points;
  std::vector<std::uint32_t> exponential;
  for (const float x : points)
    exponential.push_back(0xf5000000u | (static_cast<std::uint32_t>(std::lround(x * 2048)) & 0xffffffu));
  encoded.resize(65536);
  encoded.resize(meshopt_encodeVertexBuffer(encoded.data(), encoded.size(), exponential.data(), points.size() / 3, 12));
  made.extension_of(positions)["filter"] = "EXPONENTIAL";
  made.extension_of(positions)["byteOffset"] = made.data.size();
  made.extension_of(positions)["byteLength"] = encoded.size();
  made.data.append(encoded.begin(), encoded.end());
  made.compressed["buffers"][0]["byteLength"] = made.data.size();
  const auto rig = open_bytes(made.glb());
  CHECK(largest_distance(*rig, made.avatar, {{"tongueOut", 0.25}}) < 1e-3);
  const auto plain = open_bytes(made.avatar.glb());
  const auto sorted = [](const Mesh& mesh) {
    std::vector<std::array<std::uint32_t, 3>> all;
    for (std::size_t i = 0; i < mesh.polygon_corners.size(); i += 3) {
      std::array<std::uint32_t, 3> one = {mesh.polygon_corners[i], mesh.polygon_corners[i + 1],
                                          mesh.polygon_corners[i + 2]};
      std::rotate(one.begin(), std::ranges::min_element(one), one.end());
      all.push_back(one);
    }
    std::ranges::sort(all);
    return all;
  };
  CHECK(sorted(rig->rest()) == sorted(plain->rest()));
}

TEST_CASE("compressed views that are not whole are refused by number") {
  const MeshoptAvatar whole;
  const std::size_t view = view_of(whole.avatar.json, 0, "POSITION");
  const std::string name = format("buffer view %zu, EXT_meshopt_compression: ", view);
  const auto refused = [&](const char* key, const json& value, Status status, const std::string& message) {
    check_meshopt_refused([&](MeshoptAvatar& made) { made.extension_of(view)[key] = value; }, status, name + message);
  };
  refused("mode", "POINTS", Status::bad_data, "its mode is \"POINTS\"");
  refused("mode", 3, Status::bad_data, "its mode is no text");
  refused("filter", "COLOR", Status::unsupported, "its filter \"COLOR\" is not read");
  refused("filter", "QUATERNION", Status::bad_data, "its filter QUATERNION does not go with mode ATTRIBUTES");
  refused("byteStride", 6, Status::bad_data, "its byteStride is 6");
  refused("byteStride", 512, Status::bad_data, "its byteStride is 512");
  refused("byteLength", 1 << 30, Status::bad_data, "its data runs past the end of its buffer");
  refused("byteLength", 20, Status::bad_data, "its data cannot be decoded");
  refused("byteOffset", 0, Status::bad_data, "its data is not of mode ATTRIBUTES");
  refused("byteOffset", -4, Status::bad_data, "its byteOffset is no whole number below 2^32");
  refused("buffer", 7, Status::bad_data, "its data lies in buffer 7 of 2");
  refused("count", 0, Status::bad_data, "its count is 0");
  check_meshopt_refused([&](MeshoptAvatar& made) { made.extension_of(view)["count"] = 2000000000; }, Status::bad_data,
                        "cannot hold 2000000000 elements");
  check_meshopt_refused(
      [&](MeshoptAvatar& made) { made.data[std::size_t(made.extension_of(view)["byteOffset"])] = char(0xa1); },
      Status::unsupported, name + "its data is of version 1 of the codec; up to 0 is read");
}

TEST_CASE("what Draco compresses is decoded, with the morph targets that go with it") {
  GltfAvatar avatar;
  compress_by_draco(avatar, 2, draco::MESH_SEQUENTIAL_ENCODING);  // teeth: skinned, with a morph target
  const auto rig = open_bytes(avatar.glb());
  CHECK(largest_distance(*rig, avatar, {{"jawOpen", 0.5}}) < 2e-6);
  GltfAvatar other;
  const auto plain = open_bytes(other.glb());
  CHECK(rig->character().skin == plain->character().skin);
  CHECK(rig->rest().uvs == plain->rest().uvs);

  GltfAvatar reordered;
  compress_by_draco(reordered, 1, draco::MESH_EDGEBREAKER_ENCODING);  // the eyes
  const auto eyes = open_bytes(reordered.glb());
  REQUIRE(eyes->rest().points.size() == plain->rest().points.size());
  const auto sorted_points = [](const Mesh& mesh) {
    std::vector<std::array<float, 3>> points;
    for (std::size_t i = 0; i < mesh.points.size(); i += 3)
      points.push_back({mesh.points[i], mesh.points[i + 1], mesh.points[i + 2]});
    std::ranges::sort(points);
    return points;
  };
  CHECK(sorted_points(eyes->rest()) == sorted_points(plain->rest()));

  GltfAvatar truths;
  compress_by_draco(truths, 2, draco::MESH_SEQUENTIAL_ENCODING, draco::DT_BOOL);
  const std::string what = failure(Status::bad_data, [&] { open_bytes(truths.glb()); });
  CHECK_MESSAGE(contains(what, "mesh 2 (\"teeth\"), primitive 0: an attribute of its Draco data has truth values"),
                what);
}

TEST_CASE("Draco data that is not what the file says is refused by mesh and primitive") {
  const std::string teeth = "mesh 2 (\"teeth\"), primitive 0: ";
  const auto primitive = [](GltfAvatar& a) -> json& { return a.json["meshes"][2]["primitives"][0]; };
  const auto extension = [&](GltfAvatar& a) -> json& {
    return primitive(a)["extensions"]["KHR_draco_mesh_compression"];
  };
  const auto accessor = [&](GltfAvatar& a, const char* name) -> json& {
    return a.json["accessors"][std::size_t(primitive(a)["attributes"][name])];
  };
  check_draco_refused([&](GltfAvatar& a) { extension(a)["bufferView"] = 4000; }, Status::bad_data,
                      teeth + "its Draco data lies in buffer view 4000");
  check_draco_refused([&](GltfAvatar& a) { extension(a)["bufferView"] = 0; }, Status::bad_data,
                      teeth + "its Draco data is none, or no mesh");
  check_draco_refused([&](GltfAvatar& a) { extension(a)["attributes"]["POSITION"] = 77; }, Status::bad_data,
                      teeth + "its Draco data has no attribute 77 for POSITION");
  check_draco_refused([&](GltfAvatar& a) { accessor(a, "POSITION")["count"] = 9; }, Status::bad_data,
                      teeth + "its Draco data cannot be decoded into 9 vertices");
  check_draco_refused([&](GltfAvatar& a) { accessor(a, "POSITION")["count"] = 4000000000u; }, Status::bad_data,
                      "cannot hold 4000000000 vertices");
  check_draco_refused([&](GltfAvatar& a) { accessor(a, "WEIGHTS_0")["count"] = 7; }, Status::bad_data,
                      teeth + "its Draco data has 8 vertices, its WEIGHTS_0 7");
  check_draco_refused([&](GltfAvatar& a) { accessor(a, "POSITION")["componentType"] = 5123; }, Status::bad_data,
                      teeth + "an attribute of its Draco data has floats, and its accessor integers");
  check_draco_refused([&](GltfAvatar& a) { primitive(a)["mode"] = 5; }, Status::unsupported,
                      teeth + "its Draco data are no list of triangles");
  check_draco_refused(
      [&](GltfAvatar& a) {
        const std::size_t at = a.json["bufferViews"][std::size_t(extension(a)["bufferView"])]["byteOffset"];
        a.more().data[at + 6] = 1;
      },
      Status::unsupported, teeth + "its Draco data is of version 2.1; 2.2 is read");
}

TEST_CASE("sparse accessors change elements of others, or of zeros") {
  GltfAvatar avatar;
  GltfAvatar::Part& tongue = avatar.parts[4];
  const auto sparse = [&](std::size_t accessor, const std::vector<std::uint16_t>& elements, const auto& values,
                          std::size_t bytes) {
    json& to = avatar.json["accessors"][accessor];
    const int component = to["componentType"];
    to["sparse"] = {
        {"count", elements.size()},
        {"indices",
         {{"bufferView", avatar.more().view(elements.data(), 2 * elements.size())}, {"componentType", 5123}}},
        {"values", {{"bufferView", avatar.more().view(values.data(), bytes)}}}};
    return component;
  };
  const json& primitive = avatar.json["meshes"][3]["primitives"][0];
  const std::vector<float> moved = {1, 2, 3, -1, -2, -3};
  sparse(primitive["attributes"]["POSITION"], {1, 7}, moved, 24);
  std::copy(moved.begin(), moved.begin() + 3, tongue.points.begin() + 3);
  std::copy(moved.begin() + 3, moved.end(), tongue.points.begin() + 21);
  CHECK(largest_distance(*open_bytes(avatar.glb()), avatar, {{"tongueOut", 1}}) < 2e-6);

  // Positions and joints without a buffer of their own: zeros, but for those.
  const std::size_t positions = primitive["attributes"]["POSITION"];
  avatar.json["accessors"][positions].erase("bufferView");
  std::ranges::fill(tongue.points, 0.0f);
  std::copy(moved.begin(), moved.begin() + 3, tongue.points.begin() + 3);
  std::copy(moved.begin() + 3, moved.end(), tongue.points.begin() + 21);
  GltfAvatar::Part& teeth = avatar.parts[3];
  const std::size_t joints = avatar.json["meshes"][2]["primitives"][0]["attributes"]["JOINTS_0"];
  const std::vector<std::uint8_t> stored = {1, 0, 0, 0};
  sparse(joints, {2}, stored, 4);
  avatar.json["accessors"][joints].erase("bufferView");
  std::ranges::fill(teeth.joints, std::uint8_t(0));
  teeth.joints[8] = 1;
  CHECK(largest_distance(*open_bytes(avatar.glb()), avatar, {{"jawOpen", 1}}) < 2e-6);

  avatar.json["accessors"][joints]["sparse"]["values"]["bufferView"] = 5000;
  CHECK(contains(failure(Status::bad_data, [&] { open_bytes(avatar.glb()); }), "its joints lie in no buffer view"));
}

}  // namespace test_gltf_compression
