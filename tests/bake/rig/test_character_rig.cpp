// A rig of several meshes with materials, images and sockets: from the C struct, through a dataset and the rig
// protocol, into an archive.
#include <algorithm>
#include <fstream>
#include <numeric>

#include "archive/reader.h"
#include "bake/measure/verify.h"
#include "bake/pipeline/bake.h"
#include "bake/rig/rig_source.h"
#include "bake/rig_process/rig_messages.h"
#include "bake_test_support.h"
#include "test_models.h"

namespace test_character_rig {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

// The meshes of body_model() as a host's rig: control c moves the vertices of every fifth from c on, along z.
struct HostRig {
  PackedModel model = body_model();
  std::vector<fb_rig_control> controls;
  std::vector<fb_rig_labels> labels;
  std::vector<fb_mesh> meshes;
  std::vector<fb_material_run> runs;
  std::vector<fb_material> materials;
  std::vector<std::vector<fb_texture>> textures;
  std::vector<fb_image> images;
  std::vector<fb_socket> sockets;
  std::vector<fb_channel> channels;
  std::vector<fb_joint> joints;
  fb_rig rig;
  float scale;

  explicit HostRig(float unit = 1) : scale(unit) {
    model.character.thumbnail.clear();
    for (float& x : model.rest.points) x *= scale;
    for (Socket& socket : model.character.sockets)
      for (const std::size_t i : {3u, 7u, 11u}) socket.frame[i] *= scale;
    for (Image& image : model.character.images)
      if (image.bytes.empty()) image.bytes.push_back(std::byte(1));
    for (const Control& c : model.schema.controls)
      controls.push_back({c.name.c_str(), c.group.c_str(), c.minimum, c.maximum, c.rest, 0});
    for (const Control& c : model.schema.controls)
      labels.push_back({c.labels.arkit.c_str(), c.labels.facs.c_str(), c.labels.unit.c_str(), c.labels.mirror.c_str()});
    describe_character();
    const Mesh& rest = model.rest;
    fb_rig_init(&rig);
    rig.name = "character";
    rig.units = "cm";
    rig.up_axis = "y";
    rig.control_count = static_cast<std::uint32_t>(controls.size());
    rig.controls = controls.data();
    rig.vertex_count = static_cast<std::uint32_t>(rest.surface_vertex_count());
    rig.rest_positions = rest.points.data();
    rig.polygon_count = static_cast<std::uint32_t>(rest.polygon_sizes.size());
    rig.polygon_sizes = rest.polygon_sizes.data();
    rig.polygon_corners = rest.polygon_corners.data();
    rig.uv_count = static_cast<std::uint32_t>(rest.uvs.size() / 2);
    rig.uvs = rest.uvs.data();
    rig.uv_corners = rest.uv_corners.data();
    rig.labels = labels.data();
    rig.user = this;
    rig.evaluate = evaluate;
    rig.mesh_count = static_cast<std::uint32_t>(meshes.size());
    rig.meshes = meshes.data();
    rig.material_count = static_cast<std::uint32_t>(materials.size());
    rig.materials = materials.data();
    rig.image_count = static_cast<std::uint32_t>(images.size());
    rig.images = images.data();
    rig.socket_count = static_cast<std::uint32_t>(sockets.size());
    rig.sockets = sockets.data();
    rig.about = model.character.about.c_str();
    rig.channel_count = static_cast<std::uint32_t>(channels.size());
    rig.channels = channels.data();
    rig.evaluate_all = evaluate_all;
    rig.joint_count = static_cast<std::uint32_t>(joints.size());
    rig.joints = joints.data();
    rig.skin_influences = model.character.skin.influences;
    rig.skin_joints = model.character.skin.joints.data();
    rig.skin_weights = model.character.skin.weights.data();
  }
  HostRig(const HostRig&) = delete;

  void describe_character() {
    runs.reserve(16);
    for (const MeshPart& part : model.rest.parts) {
      meshes.push_back({sizeof(fb_mesh), static_cast<std::uint32_t>(part.materials.size()), part.name.c_str(),
                        runs.data() + runs.size(), part.vertices, part.polygons, 0, 0, 0, 0});
      for (const MaterialRun& run : part.materials) runs.push_back({run.polygons, run.material});
    }
    const Character& from = model.character;
    for (const Material& m : from.materials) {
      std::vector<fb_texture>& of = textures.emplace_back();
      for (const Texture& t : m.textures)
        of.push_back({std::uint32_t(t.slot), t.image, std::uint32_t(t.wrap_u), std::uint32_t(t.wrap_v), t.scale});
      fb_material material = {};
      material.struct_size = sizeof material;
      material.name = m.name.c_str();
      std::ranges::copy(m.base_colour, material.base_colour);
      std::ranges::copy(m.emissive, material.emissive);
      material.metallic = m.metallic;
      material.roughness = m.roughness;
      material.alpha_mode = static_cast<std::uint32_t>(m.alpha_mode);
      material.alpha_cutoff = m.alpha_cutoff;
      material.double_sided = m.double_sided;
      material.texture_count = static_cast<std::uint32_t>(of.size());
      material.textures = of.data();
      materials.push_back(material);
    }
    for (const Image& i : from.images)
      images.push_back({sizeof(fb_image), 0, i.name.c_str(), i.media_type.c_str(), i.bytes.data(), i.bytes.size()});
    for (const Socket& s : from.sockets) {
      fb_socket socket = {sizeof(fb_socket), static_cast<std::uint32_t>(s.vertices.size()),
                          s.name.c_str(),    s.vertices.data(),
                          s.weights.data(),  {}};
      std::ranges::copy(s.frame, socket.frame);
      sockets.push_back(socket);
    }
    for (const Joint& j : from.joints) {
      joints.push_back({sizeof(fb_joint), j.parent, j.name.c_str(), {}, {}});
      std::ranges::copy(j.rest, joints.back().rest);
      std::ranges::copy(j.inverse_bind, joints.back().inverse_bind);
    }
    for (const Channel& c : model.schema.channels)
      channels.push_back({sizeof(fb_channel), 0, c.name.c_str(), c.unit.c_str(), c.minimum, c.maximum, c.rest});
  }

  // Channel c goes from rest towards its maximum by a third of what control c is moved, and a tenth of its square.
  static float channel_value(const Channel& channel, const Control& control, float value) {
    const float t = value - control.rest;
    return channel.rest + (channel.maximum - channel.rest) * (0.3f * t + 0.1f * t * t);
  }

  static fb_status evaluate(void* user, std::uint64_t poses, const float* controls, float* positions, char*,
                            std::uint32_t) {
    const PackedModel& model = static_cast<const HostRig*>(user)->model;
    const float scale = static_cast<const HostRig*>(user)->scale;
    const std::size_t width = model.schema.control_count();
    const std::size_t size = model.rest.surface_points().size();
    for (std::uint64_t p = 0; p < poses; ++p, positions += size) {
      std::copy_n(model.rest.points.begin(), size, positions);
      for (std::size_t v = 0; v < size / 3; ++v)
        positions[3 * v + 2] += scale * (controls[p * width + v % width] - model.schema.controls[v % width].rest);
    }
    return FB_OK;
  }

  static fb_status evaluate_all(void* user, std::uint64_t poses, const float* controls, float* positions,
                                float* channels, char* message, std::uint32_t size) {
    const RigSchema& schema = static_cast<const HostRig*>(user)->model.schema;
    for (std::uint64_t p = 0; p < poses; ++p)
      for (std::size_t c = 0; c < schema.channels.size(); ++c)
        *channels++ = channel_value(schema.channels[c], schema.controls[c], controls[p * schema.control_count() + c]);
    return evaluate(user, poses, controls, positions, message, size);
  }
};

std::vector<ControlLabels> labels_of(const RigSchema& schema) {
  std::vector<ControlLabels> labels;
  for (const Control& control : schema.controls) labels.push_back(control.labels);
  return labels;
}

void check_same(const Source& source, const HostRig& rig) {
  CHECK(source.rest().parts == rig.model.rest.parts);
  CHECK(source.character() == rig.model.character);
  CHECK(labels_of(source.schema()) == labels_of(rig.model.schema));
  const auto same = [](const Channel& a, const Channel& b) {
    return a.name == b.name && a.unit == b.unit && a.minimum == b.minimum && a.maximum == b.maximum && a.rest == b.rest;
  };
  CHECK(std::ranges::equal(source.schema().channels, rig.model.schema.channels, same));
  CHECK(source.rest().carrier_vertices == rig.model.rest.carrier_vertices);
}

void check_refused(const std::function<void(HostRig&)>& change, const char* message) {
  HostRig rig;
  change(rig);
  CHECK(contains(failure(Status::rig, [&] { RigSource(rig.rig); }), message));
}

}  // namespace

TEST_CASE("a rig gives meshes, materials, images and sockets") {
  HostRig rig;
  check_same(RigSource(rig.rig), rig);
  rig.rig.struct_size = offsetof(fb_rig, mesh_count);
  const RigSource older(rig.rig);
  CHECK(older.rest().parts.empty());
  CHECK(older.character() == Character{});
  CHECK(labels_of(older.schema()) == std::vector<ControlLabels>(5));
}

TEST_CASE("a rig may leave out inverse bind matrices, and list influences in any order") {
  HostRig rig;
  std::fill_n(rig.joints[2].inverse_bind, 12, 0.0f);
  std::vector<std::uint16_t> joints = {0, 1, 2};
  std::vector<float> weights = {0, 1, 0};
  for (std::size_t i = 3; i < 90; ++i) {
    joints.push_back(static_cast<std::uint16_t>(i % 3 == 0 ? 0 : 2));
    weights.push_back(i >= 54 || i % 3 == 0 ? 0 : 0.5f);  // the same joint twice
  }
  rig.rig.skin_influences = 3;
  rig.rig.skin_joints = joints.data();
  rig.rig.skin_weights = weights.data();
  const RigSource source(rig.rig);
  // The inverse of the three joints at rest, one after the other.
  const Frame<float> expected = {0, 0.5f, 0, 0, -0.5f, 0, 0, -0.75f, 0, 0, 0.5f, -0.25f};
  for (std::size_t i = 0; i < 12; ++i)
    CHECK(source.character().joints[2].inverse_bind[i] == doctest::Approx(expected[i]).epsilon(1e-6));
  const Skin& skin = source.character().skin;
  CHECK(skin.influences == 1);
  CHECK(skin.joints[0] == 1);
  CHECK(skin.joints[1] == 2);
  CHECK(skin.weights[17] == 1);
  CHECK(skin.weights[18] == 0);
}

TEST_CASE("a rig may leave out runs, weights and frames") {
  HostRig rig;
  rig.meshes[0].run_count = 0;
  rig.sockets[1].weights = nullptr;
  std::fill_n(rig.sockets[1].frame, 12, 0.0f);
  const RigSource source(rig.rig);
  CHECK(source.rest().parts[0].materials == std::vector<MaterialRun>{{10, no_material}});
  const Socket& tooth = source.character().sockets[1];
  CHECK(tooth.weights == std::vector<float>{1, 1, 1});
  CHECK(tooth.frame[0] == 1);
  CHECK(tooth.frame[1] == 0);
  const std::vector<float>& points = source.rest().points;
  CHECK(tooth.frame[7] ==
        doctest::Approx((points[3 * 29 + 1] + points[3 * 23 + 1] + points[3 * 18 + 1]) / 3).epsilon(1e-6));
}

TEST_CASE("a rig whose character contradicts itself is refused by name") {
  check_refused([](HostRig& r) { r.labels[1].mirror = "jaw_open"; }, "which does not mirror it");
  check_refused([](HostRig& r) { r.meshes[1].name = nullptr; }, "the name of mesh 1 is null");
  check_refused([](HostRig& r) { r.meshes[1].name = "head"; }, "two meshes named \"head\"");
  check_refused([](HostRig& r) { r.meshes[0].runs = nullptr; }, "the runs of mesh \"head\" are null");
  check_refused([](HostRig& r) { r.rig.mesh_stride = 8; }, "mesh_stride is 8");
  check_refused([](HostRig& r) { r.materials[0].alpha_mode = 3; }, "material 0 has unknown alpha_mode 3");
  check_refused([](HostRig& r) { r.textures[0][1].slot = 5; }, "material 0 has unknown texture slot 5");
  check_refused([](HostRig& r) { r.textures[0][1].image = 3; }, "image 3 of 3");
  check_refused([](HostRig& r) { r.materials[0].textures = nullptr; }, "the textures of material 0 are null");
  check_refused([](HostRig& r) { r.images[1].bytes = nullptr; }, "image 1 has no bytes");
  check_refused([](HostRig& r) { r.images[1].media_type = ""; }, "the media type of image 1 is empty");
  check_refused([](HostRig& r) { r.sockets[0].vertex_count = 2; }, "socket \"nose\" has 2 vertices");
  check_refused([](HostRig& r) { r.sockets[0].vertices = nullptr; }, "vertices of a socket is null");
  check_refused([](HostRig& r) { r.rig.about = "[1]"; }, "about: is no object");
  check_refused([](HostRig& r) { r.rig.about = "{\"author\": 7}"; }, "about: author is no string");
  check_refused([](HostRig& r) { r.channels[1].name = ""; }, "the name of channel 1 is empty");
  check_refused([](HostRig& r) { r.channels[1].name = "frown"; }, "channel name \"frown\" occurs twice");
  check_refused([](HostRig& r) { r.channels[3].maximum = 300; }, "channel \"heat\": minimum 300 is not below");
  check_refused([](HostRig& r) { r.rig.channel_stride = 4; }, "channel_stride is 4");
  check_refused([](HostRig& r) { r.rig.evaluate_all = nullptr; }, "evaluate_all is null");
  check_refused([](HostRig& r) { r.joints[1].name = "neck"; }, "two joints named \"neck\"");
  check_refused([](HostRig& r) { r.joints[1].name = nullptr; }, "the name of joint 1 is null");
  check_refused([](HostRig& r) { r.joints[0].parent = 2; }, "parents come first");
  check_refused([](HostRig& r) { r.rig.joint_stride = 12; }, "joint_stride is 12");
  check_refused([](HostRig& r) { r.rig.joints = nullptr; }, "joints is null");
  check_refused([](HostRig& r) { r.rig.joint_count = 0; }, "a skin without joints");
  check_refused([](HostRig& r) { r.rig.joint_count = 2; }, "follows joint 2 of 2");
  check_refused([](HostRig& r) { r.rig.skin_joints = nullptr; }, "skin_joints is null");
  check_refused([](HostRig& r) { r.rig.skin_influences = 33; }, "skin_influences is 33, more than 32");
  check_refused([](HostRig& r) { r.model.character.skin.weights[5] = -1; },
                "vertex 2 follows a joint by the weight -1");
  check_refused(
      [](HostRig& r) {
        std::fill_n(r.joints[1].inverse_bind, 12, 0.0f);
        r.joints[0].rest[0] = r.joints[0].rest[1] = 0;
      },
      "joint \"head\" has no inverse bind matrix");
}

TEST_CASE("channels of a rig are clamped to their ranges, and refused where they are not finite") {
  HostRig rig;
  rig.rig.evaluate_all = [](void* user, std::uint64_t poses, const float* controls, float* positions, float* channels,
                            char* message, std::uint32_t size) {
    const fb_status status = HostRig::evaluate_all(user, poses, controls, positions, channels, message, size);
    for (std::uint64_t p = 0; p < poses; ++p)
      if (controls[5 * p] > 0.5f) channels[4 * p + 1] = controls[5 * p] > 0.75f ? NAN : 7;
    return status;
  };
  RigSource source(rig.rig);
  std::vector<float> pose = source.schema().rest_pose(), points(96);
  pose[0] = 0.7f;
  source.evaluate(pose, 1, points);
  CHECK(source.schema().channels[1].value(points[91]) == 1);
  pose[0] = 0.8f;
  CHECK(contains(failure(Status::not_finite, [&] { source.evaluate(pose, 1, points); }), "channel 1 is not finite"));
}

TEST_CASE("the rig protocol carries a character") {
  HostRig rig;
  const RigDescription description = description_of(hello_answer(RigSource(rig.rig)));
  CHECK(description.rest.parts == rig.model.rest.parts);
  CHECK(description.character == rig.model.character);
  CHECK(labels_of(description.schema) == labels_of(rig.model.schema));
  RigSource source(rig.rig);
  std::vector<float> pose = source.schema().rest_pose(), points(96), received(96);
  for (float& value : pose) value += 0.25f;
  source.evaluate(pose, 1, points);
  CHECK_FALSE(read_answer(points_answer(source, points, 1), description, 1, received));
  for (std::size_t i = 0; i < points.size(); ++i) CHECK(received[i] == doctest::Approx(points[i]).epsilon(1e-6));
  RigMessage cut = points_answer(source, points, 1);
  cut.data.resize(cut.data.size() - 4);
  CHECK(contains(failure(Status::rig, [&] { read_answer(cut, description, 1, received); }), "in 372 bytes"));
}

TEST_CASE("a dataset folder keeps a character") {
  HostRig rig;
  RigSource source(rig.rig);
  const Folder folder;
  sample(source, {.poses = 40}, folder.path(), {}, silent_progress());
  const OpenedSource recorded = open_source(folder.path());
  check_same(*recorded, rig);
  std::vector<float> evaluated(96), read(96);
  for (std::size_t i = 0; i < recorded->clips().size(); ++i) {
    source.evaluate(frames_of(recorded->clips()[i], 0, 1, 5), 1, evaluated);
    recorded->read(i, 0, 1, read);
    for (std::size_t k = 0; k < 96; ++k) CHECK(read[k] == doctest::Approx(evaluated[k]).epsilon(1e-6));
  }
  CHECK(std::filesystem::exists(folder.path() / "image0.png"));
  std::filesystem::remove(folder.path() / "image0.png");
  CHECK(contains(failure(Status::not_found, [&] { open_source(folder.path()); }), "image0.png"));
}

TEST_CASE("fields of a character in dataset.json are refused by name") {
  HostRig rig;
  RigSource source(rig.rig);
  const Folder folder;
  sample(source, {.poses = 40}, folder.path(), {}, silent_progress());
  const std::filesystem::path file = folder.path() / "dataset.json";
  const std::vector<std::byte> bytes = read_file(file);
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto lie = [&](const std::string& from, const std::string& to, const char* message) {
    std::string changed = text;
    REQUIRE(changed.find(from) != std::string::npos);
    changed.replace(changed.find(from), from.size(), to);
    write_file(file, changed);
    const std::string what = failure(Status::bad_data, [&] { open_source(folder.path()); });
    CHECK_MESSAGE(contains(what, message), what);
  };
  lie("\"learning\": \"forbidden\"", "\"learning\": false", "about: rights learning is no string");
  lie("\"vertices\": 18", "\"vertices\": -18", "meshes[0] vertices is no whole number");
  lie("\"vertices\": 18", "\"vertices\": 17", "mesh \"head\": polygon");
  lie("\"slot\": \"normal\"", "\"slot\": \"bump\"", "slot is \"bump\"; there are base_colour, metallic_roughness");
  lie("\"alpha_mode\": \"mask\"", "\"alpha_mode\": 7", "materials[0] alpha_mode is no string");
  lie("\"file\": \"image0.png\"", "\"file\": \"../image0.png\"", "does not lie in its folder");
  lie("\"file\": \"image0.png\"", "\"path\": \"image0.png\"", "images[0] file is missing");
  lie("\"unit\": \"K\"", "\"unit\": 7", "channels[3] unit is no string");
  lie("\"channels\": \"", "\"chennels\": \"", "has points but no channels");
  lie("\"parent\": 0", "\"parent\": -1", "joints[1] parent is no whole number");
  lie("\"parent\": 0", "\"parent\": 1", "joint \"head\" has the number 1 and its parent 1");
  lie("\"inverse_bind\": [", "\"inverse_bind\": [1,", "joints[0] inverse_bind has 13 numbers, not 12");
  lie("\"skin_weights.npy\"", "\"rest.npy\"", "shape (30, 3) where (30, influences), 1 to 32, is needed");
  lie("\"skin_joints.npy\"", "7", "skin joints is no string");
  lie("\"sockets\": [", "\"sockets\": 7, \"x\": [", "sockets is no list");
}

TEST_CASE("a bake within a number of bytes keeps a character") {
  HostRig rig;
  RigSource source(rig.rig);
  const Folder folder;
  BakeOptions options;
  options.recipe = "linear";
  options.poses = 300;
  options.work = folder.path();
  options.max_bytes = 10000;
  const Baked smaller = bake_face(source, options, silent_progress());
  CHECK(smaller.archive.size() <= options.max_bytes);
  CHECK(archive::read_archive(smaller.archive).model.character == rig.model.character);
  CHECK(archive::read_archive(smaller.archive).model.rest.parts == rig.model.rest.parts);
}

TEST_CASE("a bake keeps a character, whatever its scale and recipe") {
  const std::pair<const char*, float> bakes[] = {{"linear", 1}, {"untrained", 1}, {"compact", 1}, {"compact", 0x1p40f}};
  for (const auto& [recipe, scale] : bakes) {
    HostRig rig(scale);
    rig.model.character.about = R"({"name":"Ada","shelf":7})";  // which forbids nothing, as others do
    rig.rig.about = rig.model.character.about.c_str();
    RigSource source(rig.rig);
    const Folder folder;
    BakeOptions options;
    options.recipe = recipe;
    options.poses = 300;
    options.epochs = 2;
    options.work = folder.path();
    const Baked baked = bake_face(source, options, silent_progress());
    const archive::Archive archive = archive::read_archive(baked.archive);
    CHECK(archive.model.rest.parts == rig.model.rest.parts);
    CHECK(archive.model.character == rig.model.character);
    CHECK(labels_of(archive.model.schema) == labels_of(rig.model.schema));
    CHECK(verify_archive(baked.archive).poses == 11);
    CHECK(baked.dependency.max < 1e-2);
    REQUIRE(baked.dependency.channels.size() == 4);
    for (const ChannelErrors& channel : baked.dependency.channels) {
      INFO(channel.name);
      CHECK(channel.rms > 0);
      CHECK(channel.max < (options.recipe == "linear" ? 0.3 : 0.03));
    }
    CHECK(baked.dependency.channels[3].name == "heat");
  }
}

}  // namespace test_character_rig
