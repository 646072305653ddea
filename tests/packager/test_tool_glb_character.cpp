// pose writes whole characters to glTF and .obj: an independent reader finds their meshes, materials, images, sockets
// and morph targets.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "archive/writer.h"
#include "bake/dataset/npy.h"
#include "bake/dataset/open_source.h"
#include "bake/rig/source.h"
#include "base/file.h"
#include "base/surface.h"
#include "glb_reading.h"
#include "runtime/evaluator.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_glb_character {

namespace {

struct Mesh {
  const char* name;
  std::size_t first, count;  // vertices
};
constexpr Mesh meshes[] = {{"head", 0, 18}, {"teeth", 18, 12}};

fb::PackedModel write_character(const std::string& path, const fb::PackedModel& model = fb::character_model()) {
  const auto bytes = fb::archive::write_archive(model, {});
  fb::write_file(path, bytes);
  return fb::archive::read_archive(bytes).model;
}

std::vector<float> part(const std::vector<float>& points, const Mesh& mesh, std::size_t frame = 0) {
  const std::size_t size = 3 * 30;
  const auto first = points.begin() + static_cast<std::ptrdiff_t>(frame * size + 3 * mesh.first);
  return {first, first + static_cast<std::ptrdiff_t>(3 * mesh.count)};
}

std::vector<std::byte> image_bytes(const tinygltf::Model& model, int image) {
  const int view = model.images.at(image).bufferView;
  return view_values<std::byte>(model, view, 0, model.bufferViews.at(view).byteLength);
}

// The image that a texture shows by itself or, where `extension` is not null, by that extension alone.
int image_of(const tinygltf::Model& model, int texture, const char* extension = nullptr) {
  const auto& found = model.textures.at(texture);
  if (!extension) return found.source;
  CHECK(found.source == -1);
  return found.extensions.at(extension).Get("source").GetNumberAsInt();
}

void check_triangles(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const fb::Mesh& rest,
                     std::size_t first, std::size_t count, const Mesh& mesh) {
  const auto& indices = model.accessors.at(primitive.indices);
  auto found = view_values<std::uint32_t>(model, indices.bufferView, 0, indices.count);
  for (std::uint32_t& vertex : found) vertex += static_cast<std::uint32_t>(mesh.first);
  const auto all = rest.triangles();
  CHECK(found == std::vector<std::uint32_t>(all.begin() + static_cast<std::ptrdiff_t>(3 * first),
                                            all.begin() + static_cast<std::ptrdiff_t>(3 * (first + count))));
}

// Frames of the sockets: poses x sockets x 12.
std::vector<float> socket_frames(const fb::PackedModel& face, const std::vector<float>& controls) {
  const fb::runtime::Evaluator evaluator(face);
  std::vector<fb::runtime::Workspace> workspaces;
  workspaces.emplace_back(evaluator);
  fb::runtime::Batch batch;
  batch.poses = controls.size() / evaluator.control_count();
  batch.controls = controls;
  std::vector<float> frames(12 * evaluator.socket_count() * batch.poses);
  batch.sockets = {frames.data(), frames.size()};
  evaluator.evaluate_batch(batch, workspaces);
  return frames;
}

// The point of a node's parent where glTF puts a point of the node.
std::vector<double> placed(const float* move, const float* turn, const std::vector<double>& scale,
                           const std::vector<double>& point) {
  std::vector<double> p(3), q(turn, turn + 4);
  for (std::size_t i = 0; i < 3; ++i) p[i] = point[i] * scale[i];
  const auto cross = [&](const std::vector<double>& a) {
    return std::vector<double>{q[1] * a[2] - q[2] * a[1], q[2] * a[0] - q[0] * a[2], q[0] * a[1] - q[1] * a[0]};
  };
  const auto once = cross(p), twice = cross(once);
  for (std::size_t i = 0; i < 3; ++i) p[i] += 2 * (q[3] * once[i] + twice[i]) + move[i];
  return p;
}

void check_socket(const float* frame, const float* move, const float* turn, const std::vector<double>& scale) {
  for (const std::vector<double>& point : {std::vector<double>{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
    const auto found = placed(move, turn, scale, point);
    for (std::size_t row = 0; row < 3; ++row) {
      double expected = frame[4 * row + 3];
      for (std::size_t i = 0; i < 3; ++i) expected += frame[4 * row + i] * point[i];
      CHECK(found[row] == doctest::Approx(expected).epsilon(1e-5));
    }
  }
}

std::vector<std::string> target_names(const tinygltf::Model& model, const tinygltf::Node& node) {
  const auto& names = model.meshes.at(node.mesh).extras.Get("targetNames");
  std::vector<std::string> list;
  for (std::size_t i = 0; i < names.ArrayLen(); ++i) list.push_back(names.Get(static_cast<int>(i)).Get<std::string>());
  return list;
}

// The controls that move a mesh by themselves, at their maximum.
std::vector<std::size_t> moving_controls(const fb::PackedModel& face, const Mesh& mesh) {
  std::vector<std::size_t> moving;
  for (std::size_t c = 0; c < face.schema.control_count(); ++c) {
    auto full = face.schema.rest_pose();
    full[c] = face.schema.controls[c].maximum;
    if (part(evaluate_clip(face, full), mesh) != part(face.rest.points, mesh)) moving.push_back(c);
  }
  return moving;
}

std::string text_of(const std::string& path) {
  const auto bytes = fb::read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

TEST_CASE("each mesh of a character becomes a node and a mesh with a primitive for each run of polygons") {
  const ScratchFolder folder;
  const fb::PackedModel face = write_character(folder / "face.fbk");
  REQUIRE(run_tool({"pose", folder / "face.fbk", "--set", "jaw_open=1", "--out", folder / "x.glb"}).exit_code == 0);
  auto controls = face.schema.rest_pose();
  controls[0] = 1;
  const auto expected = evaluate_clip(face, controls);
  const tinygltf::Model model = load_glb(folder / "x.glb");
  CHECK(model.animations.empty());
  REQUIRE(model.scenes.at(0).nodes == std::vector<int>{0});
  CHECK(model.nodes[0].mesh == -1);
  CHECK(model.nodes[0].scale == std::vector<double>(3, 0.01));
  CHECK(model.nodes[0].children.size() == 4);  // two meshes, two sockets
  CHECK(model.meshes.size() == 2);
  for (const Mesh& mesh : meshes) {
    const tinygltf::Node& node = node_named(model, mesh.name);
    const tinygltf::Mesh& found = model.meshes.at(node.mesh);
    CHECK(found.name == mesh.name);
    for (const auto& primitive : found.primitives) {
      CHECK(primitive.attributes == found.primitives[0].attributes);  // shared
      CHECK(floats(model, primitive.attributes.at("POSITION")) == part(expected, mesh));
      const auto uvs = floats(model, primitive.attributes.at("TEXCOORD_0"));
      for (std::size_t v = 0; v < mesh.count; ++v) {
        CHECK(uvs[2 * v] == face.rest.uvs[2 * (mesh.first + v)]);
        CHECK(uvs[2 * v + 1] == 1 - face.rest.uvs[2 * (mesh.first + v) + 1]);
      }
    }
  }
  const auto &head = model.meshes[0].primitives, &teeth = model.meshes[1].primitives;
  REQUIRE(head.size() == 2);
  REQUIRE(teeth.size() == 1);
  CHECK(head[0].material == 0);
  CHECK(head[1].material == -1);
  CHECK(teeth[0].material == 1);
  check_triangles(model, head[0], face.rest, 0, 12, meshes[0]);
  check_triangles(model, head[1], face.rest, 12, 8, meshes[0]);
  check_triangles(model, teeth[0], face.rest, 20, 10, meshes[1]);
}

TEST_CASE("materials and images are those of the character") {
  const ScratchFolder folder;
  fb::PackedModel made = fb::character_model();
  auto& images = made.character.images;
  const auto bytes = [](std::size_t size, int value) { return std::vector<std::byte>(size, std::byte(value)); };
  images.push_back({"gloss", "image/ktx2", bytes(13, 3)});
  images.push_back({"glow", "image/webp", bytes(9, 4)});
  images.push_back({"odd", "image/x-exr", bytes(5, 5)});
  auto& textures = made.character.materials[0].textures;
  textures.push_back({fb::TextureSlot::metallic_roughness, 3});
  textures.push_back({fb::TextureSlot::occlusion, 0, fb::Wrap::repeat, fb::Wrap::repeat, 0.25f});
  textures.push_back({fb::TextureSlot::emissive, 4});
  made.character.materials[1].textures = {{fb::TextureSlot::base_colour, 2}, {fb::TextureSlot::normal, 5}};
  made.character.materials[1].emissive = {0, 4, 1};
  write_character(folder / "face.fbk", made);
  const ToolRun run = run_tool({"pose", folder / "face.fbk", "--out", folder / "x.glb"});
  REQUIRE(run.exit_code == 0);
  CHECK(run.err.find("image 2 (\"\") is empty and is left out") != std::string::npos);
  CHECK(run.err.find("image 5 (\"odd\") is image/x-exr, which glTF does not hold, and is left out") !=
        std::string::npos);
  const tinygltf::Model model = load_glb(folder / "x.glb");
  REQUIRE(model.materials.size() == 2);
  const tinygltf::Material &skin = model.materials[0], &other = model.materials[1];
  CHECK(skin.name == "skin");
  CHECK(skin.pbrMetallicRoughness.baseColorFactor == std::vector<double>{0.5, 0.25, 0.125, 1});
  CHECK(skin.pbrMetallicRoughness.metallicFactor == 0);
  CHECK(skin.pbrMetallicRoughness.roughnessFactor == 0.75);
  CHECK(skin.emissiveFactor == std::vector<double>{0, 0.5, 0});
  CHECK(skin.alphaMode == "MASK");
  CHECK(skin.alphaCutoff == 0.25);
  CHECK(skin.doubleSided);
  CHECK(other.name == "");
  CHECK(other.alphaMode == "BLEND");
  CHECK(other.pbrMetallicRoughness.baseColorFactor == std::vector<double>{1, 1, 1, 0.5});
  CHECK(other.pbrMetallicRoughness.roughnessFactor == 0);
  CHECK_FALSE(other.doubleSided);
  CHECK(other.emissiveFactor == std::vector<double>{0, 1, 0.25});
  CHECK(other.extensions.at("KHR_materials_emissive_strength").Get("emissiveStrength").GetNumberAsDouble() == 4);
  CHECK(other.pbrMetallicRoughness.baseColorTexture.index == -1);  // its images are left out
  CHECK(other.normalTexture.index == -1);

  REQUIRE(model.images.size() == 4);
  const auto holds = [&](int image, std::size_t index) {
    CHECK(model.images.at(image).name == images[index].name);
    CHECK(model.images.at(image).mimeType == images[index].media_type);
    CHECK(image_bytes(model, image) == images[index].bytes);
  };
  holds(image_of(model, skin.pbrMetallicRoughness.baseColorTexture.index), 0);
  holds(image_of(model, skin.normalTexture.index), 1);
  holds(image_of(model, skin.pbrMetallicRoughness.metallicRoughnessTexture.index, "KHR_texture_basisu"), 3);
  holds(image_of(model, skin.occlusionTexture.index), 0);
  holds(image_of(model, skin.emissiveTexture.index, "EXT_texture_webp"), 4);
  CHECK(skin.occlusionTexture.index == skin.pbrMetallicRoughness.baseColorTexture.index);  // of one image, one texture
  CHECK(skin.normalTexture.scale == 0.5);
  CHECK(skin.occlusionTexture.strength == 0.25);
  const auto& sampler = model.samplers.at(model.textures.at(skin.normalTexture.index).sampler);
  CHECK(sampler.wrapS == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE);
  CHECK(sampler.wrapT == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT);
  using Names = std::vector<std::string>;
  CHECK(model.extensionsRequired == Names{"KHR_texture_basisu", "EXT_texture_webp"});
  CHECK(model.extensionsUsed == Names{"KHR_texture_basisu", "EXT_texture_webp", "KHR_materials_emissive_strength"});
}

TEST_CASE("textures need texture coordinates") {
  const ScratchFolder folder;
  fb::PackedModel made = fb::character_model();
  made.rest.uvs.clear();
  made.rest.uv_corners.clear();
  write_character(folder / "face.fbk", made);
  const ToolRun run = run_tool({"pose", folder / "face.fbk", "--out", folder / "x.glb"});
  REQUIRE(run.exit_code == 0);
  CHECK(run.err.find("no texture coordinates") != std::string::npos);
  const tinygltf::Model model = load_glb(folder / "x.glb");
  CHECK(model.materials.at(0).name == "skin");
  CHECK(model.textures.empty());
}

TEST_CASE("sockets are nodes that follow the surface") {
  const ScratchFolder folder;
  fb::PackedModel made = fb::character_model();
  made.character.sockets[1].frame = {0, 0, 2, 1, -3, 0, 0, 2, 0, 1, 0, -4};  // scaled and mirrored
  const fb::PackedModel face = write_character(folder / "face.fbk", made);
  constexpr std::size_t frames = 12;
  const auto controls = write_clip(folder / "clip.npy", face.schema, frames);
  const auto expected = socket_frames(face, controls);
  REQUIRE(run_tool({"pose", folder / "face.fbk", "--clip", folder / "clip.npy", "--out", folder / "x.glb"}).exit_code ==
          0);
  const tinygltf::Model model = load_glb(folder / "x.glb");
  const char* names[] = {"nose", "tooth"};
  for (std::size_t s = 0; s < 2; ++s) {
    const tinygltf::Node& node = node_named(model, names[s]);
    CHECK(node.mesh == -1);
    const auto moves = channel_of(model, names[s], "translation"), turns = channel_of(model, names[s], "rotation");
    REQUIRE(moves.size() == 3 * frames);
    REQUIRE(turns.size() == 4 * frames);
    for (std::size_t f = 0; f < frames; ++f)
      check_socket(&expected[12 * (2 * f + s)], &moves[3 * f], &turns[4 * f], node.scale);
    for (std::size_t i = 0; i < 3; ++i) CHECK(node.translation.at(i) == doctest::Approx(moves[i]));
    for (std::size_t i = 0; i < 4; ++i) CHECK(node.rotation.at(i) == doctest::Approx(turns[i]));
  }
  CHECK(node_named(model, "tooth").scale[0] == doctest::Approx(-3));
}

TEST_CASE("a clip of a character moves each mesh by targets of its own, within the tolerance") {
  const ScratchFolder folder;
  const fb::PackedModel face = write_character(folder / "face.fbk");
  constexpr std::size_t frames = 40;
  const auto expected = evaluate_clip(face, write_clip(folder / "clip.npy", face.schema, frames));
  std::size_t before = frames + 1;
  for (const char* tolerance : {"0", "1e-5", "0.02", "0.5"}) {
    CAPTURE(tolerance);
    const ToolRun run = run_tool({"pose", folder / "face.fbk", "--clip", folder / "clip.npy", "--tolerance", tolerance,
                                  "--out", folder / "x.glb", "--json"});
    REQUIRE(run.exit_code == 0);
    const auto figures = nlohmann::json::parse(run.out);
    const tinygltf::Model model = load_glb(folder / "x.glb");
    double largest = 0;
    std::size_t most = 0;
    for (const Mesh& mesh : meshes) {
      const tinygltf::Node& node = node_named(model, mesh.name);
      const auto weights = channel_of(model, mesh.name, "weights");
      const std::size_t targets = model.meshes.at(node.mesh).primitives[0].targets.size();
      REQUIRE(weights.size() == frames * targets);
      CHECK(figures["targets"][mesh.name] == targets);
      most = std::max(most, targets);
      for (const auto& primitive : model.meshes[node.mesh].primitives) CHECK(primitive.targets.size() == targets);
      for (std::size_t f = 0; f < frames; ++f) {
        const auto points = morphed_points(model, node, weights.data() + f * targets), posed = part(expected, mesh, f);
        for (std::size_t i = 0; i < points.size(); i += 3)
          largest = std::max<double>(
              largest, std::hypot(points[i] - posed[i], points[i + 1] - posed[i + 1], points[i + 2] - posed[i + 2]));
      }
    }
    const double diagonal = face.rest.diagonal();
    CHECK(largest <= std::max(std::stod(tolerance), 1e-6) * diagonal);
    CHECK(figures["target_error"]["max"].get<double>() == doctest::Approx(largest).epsilon(0.01).scale(1e-4));
    CHECK(figures["units"] == "cm");
    CHECK(most < before);  // fewer with more tolerance
    before = most;
  }
  CHECK(before == 0);  // nothing moves by more than half of the diagonal
}

TEST_CASE("a frame that no sum of targets gives is a target of its own, and the others stay sums") {
  const ScratchFolder folder;
  const fb::PackedModel face = fb::exact_model();
  fb::write_file(folder / "face.fbk", fb::archive::write_archive(face, {}));
  constexpr std::size_t frames = 300;
  std::vector<float> controls = write_clip(folder / "clip.npy", face.schema, frames);
  std::ranges::copy(face.exact[0].controls, controls.begin() + 100 * std::ptrdiff_t(face.schema.control_count()));
  fb::bake::write_npy(folder / "clip.npy", {frames, face.schema.control_count()}, std::span<const float>(controls));
  for (const std::vector<std::string>& options : {std::vector<std::string>{}, {"--tolerance", "1e-5"}}) {
    std::vector<std::string> words = {"pose",  folder / "face.fbk", "--clip", folder / "clip.npy",
                                      "--out", folder / "x.glb",    "--json"};
    words.insert(words.end(), options.begin(), options.end());
    const ToolRun run = run_tool(words);
    CAPTURE(run.err);
    REQUIRE(run.exit_code == 0);
    const auto figures = nlohmann::json::parse(run.out);
    for (const auto& count : figures["targets"]) CHECK(count.get<std::size_t>() < frames / 3);
    CHECK(figures["target_error"]["max_over_diagonal"].get<double>() <= 1e-5);
    CHECK(run.err.find("a target a frame") == std::string::npos);
  }
}

TEST_CASE("targets that take more than 256 MB are refused before the work, unless forced") {
  const ScratchFolder folder;
  const fb::PackedModel face = write_character(folder / "face.fbk");
  constexpr std::size_t frames = 10'000;  // with a weight in each for the target of each
  const std::vector<float> controls(frames * face.schema.control_count());
  fb::bake::write_npy(folder / "clip.npy", {frames, face.schema.control_count()}, std::span<const float>(controls));
  fb::write_file(folder / "x.glb", std::string("precious"));
  const ToolRun run = run_tool(
      {"pose", folder / "face.fbk", "--clip", folder / "clip.npy", "--tolerance", "0", "--out", folder / "x.glb"});
  CAPTURE(run.err);
  CHECK(run.exit_code == 1);
  CHECK(run.err.find("facebaker pose: 10000 morph targets of 18 vertices, with weights of 10000 frames, would take up "
                     "to 0.40 GB") != run.err.npos);
  CHECK(run.err.find("--force") != run.err.npos);
  CHECK(fb::read_file(folder / "x.glb").size() == 8);
}

TEST_CASE("normals of a clip are the closest that its targets' weights give") {
  const ScratchFolder folder;
  const fb::PackedModel face = write_character(folder / "face.fbk");
  constexpr std::size_t frames = 40;
  const auto expected = evaluate_clip(face, write_clip(folder / "clip.npy", face.schema, frames));
  REQUIRE(run_tool({"pose", folder / "face.fbk", "--clip", folder / "clip.npy", "--tolerance", "0.02", "--out",
                    folder / "x.glb"})
              .exit_code == 0);
  const tinygltf::Model model = load_glb(folder / "x.glb");
  const auto& head = model.meshes.at(node_named(model, "head").mesh).primitives.at(0);
  const auto weights = channel_of(model, "head", "weights"), rest = floats(model, head.attributes.at("NORMAL"));
  const std::size_t targets = head.targets.size();
  REQUIRE(targets > 0);
  std::vector<std::vector<float>> turns;
  for (const auto& target : head.targets) {
    CHECK_FALSE(model.accessors.at(target.at("POSITION")).sparse.isSparse);  // principal components move all vertices
    turns.push_back(floats(model, target.at("NORMAL")));
  }
  // What is left is at right angles to every target's weights.
  std::vector<double> left(targets * rest.size());
  double largest = 0;
  for (std::size_t f = 0; f < frames; ++f) {
    std::vector<float> points(expected.begin() + static_cast<std::ptrdiff_t>(f * 90),
                              expected.begin() + static_cast<std::ptrdiff_t>((f + 1) * 90));
    const auto normals = fb::vertex_normals(face.rest.triangles(), points);
    for (std::size_t i = 0; i < rest.size(); ++i) {
      const fb::Vector3& n = normals[i / 3];
      double remainder = (i % 3 == 0 ? n.x : i % 3 == 1 ? n.y : n.z) - double(rest[i]);
      for (std::size_t t = 0; t < targets; ++t) remainder -= weights[f * targets + t] * turns[t][i];
      largest = std::max(largest, std::fabs(remainder));
      for (std::size_t t = 0; t < targets; ++t) left[t * rest.size() + i] += weights[f * targets + t] * remainder;
    }
  }
  CHECK(largest > 1e-3);  // there is something left
  for (const double sum : left) CHECK(std::fabs(sum) < 1e-4);
}

TEST_CASE("an exported animation of a character opens as a rig with the same meshes and motion, in metres") {
  const ScratchFolder folder;
  const fb::PackedModel face = write_character(folder / "face.fbk");
  for (const std::size_t frames : {3, 40}) {
    CAPTURE(frames);
    auto expected = evaluate_clip(face, write_clip(folder / "clip.npy", face.schema, frames));
    for (float& coordinate : expected) coordinate *= 0.01f;
    REQUIRE(
        run_tool({"pose", folder / "face.fbk", "--clip", folder / "clip.npy", "--out", folder / "x.glb"}).exit_code ==
        0);
    const auto rig = fb::bake::open_source(folder / "x.glb");
    REQUIRE(rig->rest().parts.size() == 2);
    for (std::size_t m = 0; m < 2; ++m) {
      CHECK(rig->rest().parts[m].name == meshes[m].name);
      CHECK(rig->rest().parts[m].vertices == meshes[m].count);
      std::vector<fb::MaterialRun> runs = face.rest.parts[m].materials;
      for (fb::MaterialRun& run : runs) run.polygons *= 2;  // two triangles for each quad
      CHECK(rig->rest().parts[m].materials == runs);
    }
    REQUIRE(rig->clips().size() == 1);
    REQUIRE(rig->clips()[0].frames == frames);
    std::vector<float> points(expected.size());
    rig->read(0, 0, frames, points);
    CHECK(largest_difference(points.data(), expected.data(), points.size()) < 1.1e-5 * rig->rest().diagonal());
  }
}

TEST_CASE("a mesh that does not move has no targets") {
  const ScratchFolder folder;
  fb::PackedModel made = fb::character_model();
  fb::PackedRowBlock& teeth_rows = made.row_blocks[2];
  teeth_rows.columns.clear();
  teeth_rows.values.clear();
  write_character(folder / "face.fbk", made);
  write_clip(folder / "clip.npy", made.schema, 6);
  REQUIRE(run_tool({"pose", folder / "face.fbk", "--clip", folder / "clip.npy", "--out", folder / "x.glb"}).exit_code ==
          0);
  const tinygltf::Model model = load_glb(folder / "x.glb");
  const auto& teeth = model.meshes.at(node_named(model, "teeth").mesh);
  CHECK(teeth.primitives.at(0).targets.empty());
  CHECK(teeth.weights.empty());
  CHECK(channel_of(model, "teeth", "weights").empty());
  CHECK_FALSE(channel_of(model, "head", "weights").empty());
}

TEST_CASE("controls become morph targets that other programs pose the face with") {
  const ScratchFolder folder;
  const fb::PackedModel face = write_character(folder / "face.fbk");
  constexpr std::size_t frames = 7;
  const auto controls = write_clip(folder / "clip.npy", face.schema, frames);
  const auto expected = evaluate_clip(face, controls);
  const ToolRun run = run_tool({"pose", folder / "face.fbk", "--clip", folder / "clip.npy", "--control-targets",
                                "--out", folder / "x.glb", "--json"});
  REQUIRE(run.exit_code == 0);
  const tinygltf::Model model = load_glb(folder / "x.glb");
  double largest = 0, squares = 0;
  for (const Mesh& mesh : meshes) {
    const tinygltf::Node& node = node_named(model, mesh.name);
    const auto names = target_names(model, node);
    std::vector<std::string> expected_names;
    for (const std::size_t c : moving_controls(face, mesh)) expected_names.push_back(face.schema.controls[c].name);
    CHECK(names == expected_names);
    CHECK(names.size() > 1);
    const auto weights = channel_of(model, mesh.name, "weights");
    REQUIRE(weights.size() == frames * names.size());
    for (std::size_t t = 0; t < names.size(); ++t) {
      const auto c = face.schema.find(names[t]).value();
      const fb::Control& control = face.schema.controls[c];
      auto full = face.schema.rest_pose();
      full[c] = control.maximum;
      std::vector<float> one(names.size());
      one[t] = 1;
      const auto posed = part(evaluate_clip(face, full), mesh), found = morphed_points(model, node, one.data());
      CHECK(largest_difference(found.data(), posed.data(), posed.size()) < 1e-5);
      for (std::size_t f = 0; f < frames; ++f)
        CHECK(weights[f * names.size() + t] ==
              doctest::Approx((controls[f * 5 + c] - control.rest) / (control.maximum - control.rest)));
    }
    for (std::size_t f = 0; f < frames; ++f) {
      const auto posed = part(expected, mesh, f), found = morphed_points(model, node, &weights[f * names.size()]);
      for (std::size_t i = 0; i < posed.size(); i += 3) {
        const double off = std::hypot(posed[i] - found[i], posed[i + 1] - found[i + 1], posed[i + 2] - found[i + 2]);
        largest = std::max(largest, off);
        squares += off * off;
      }
    }
  }
  const auto error = nlohmann::json::parse(run.out)["target_error"];
  CHECK(error["max"].get<double>() == doctest::Approx(largest).epsilon(1e-3));
  CHECK(error["rms"].get<double>() == doctest::Approx(std::sqrt(squares / (30 * frames))).epsilon(1e-3));
}

TEST_CASE("targets of controls have ARKit names where asked, and the weights of a pose") {
  const ScratchFolder folder;
  const fb::PackedModel face = write_character(folder / "face.fbk");
  const ToolRun run = run_tool({"pose", folder / "face.fbk", "--set", "jaw_open=0.25", "--set", "lid_close=0.5",
                                "--control-targets", "--arkit-names", "--out", folder / "x.glb"});
  REQUIRE(run.exit_code == 0);
  CHECK(run.out.find("without what controls do in combination, off by at most") != std::string::npos);
  const tinygltf::Model model = load_glb(folder / "x.glb");
  const tinygltf::Node& head = node_named(model, "head");
  const char* arkit[] = {"jawOpen", "mouth_side", "brow_raise", "eyeBlinkLeft", "nose_wrinkle"};
  const double all_weights[] = {0.25, 0, 0, 0.25, 0};
  std::vector<std::string> names;
  std::vector<double> weights;
  for (const std::size_t c : moving_controls(face, meshes[0])) {
    names.emplace_back(arkit[c]);
    weights.push_back(all_weights[c]);
  }
  CHECK(names[0] == "jawOpen");
  CHECK(target_names(model, head) == names);
  CHECK(model.meshes.at(head.mesh).weights == weights);
  CHECK(model.animations.empty());
  const ToolRun rest =
      run_tool({"pose", folder / "face.fbk", "--control-targets", "--out", folder / "rest.glb", "--json"});
  REQUIRE(rest.exit_code == 0);
  CHECK(rest.out.find("target_error") == std::string::npos);  // at rest nothing is off
}

TEST_CASE("options of targets are refused where they mean nothing") {
  const ScratchFolder folder;
  write_character(folder / "face.fbk");
  const ToolRun picture = run_tool({"pose", folder / "face.fbk", "--control-targets", "--out", folder / "x.obj"});
  CHECK(picture.exit_code == 1);
  CHECK(is_error_line(picture.err, "pose", {"--control-targets", ".glb"}));
  const ToolRun alone = run_tool({"pose", folder / "face.fbk", "--arkit-names", "--out", folder / "x.glb"});
  CHECK(alone.exit_code == 1);
  CHECK(is_error_line(alone.err, "pose", {"--arkit-names", "--control-targets"}));
  CHECK(folder.names() == std::vector<std::string>{"face.fbk"});
}

TEST_CASE("a face without polygons becomes points") {
  const ScratchFolder folder;
  fb::PackedModel made = fb::tiny_packed_model();
  made.rest.polygon_sizes.clear();
  made.rest.polygon_corners.clear();
  const fb::PackedModel face = write_character(folder / "face.fbk", made);
  REQUIRE(run_tool({"pose", folder / "face.fbk", "--out", folder / "x.glb"}).exit_code == 0);
  const tinygltf::Model model = load_glb(folder / "x.glb");
  const auto& primitive = model.meshes.at(0).primitives.at(0);
  CHECK(primitive.mode == TINYGLTF_MODE_POINTS);
  CHECK(primitive.indices == -1);
  CHECK(floats(model, primitive.attributes.at("POSITION")) == face.rest.points);
  CHECK(primitive.attributes.count("NORMAL") == 0);
}

TEST_CASE("an .obj names meshes and materials") {
  const ScratchFolder folder;
  write_character(folder / "face.fbk");
  REQUIRE(run_tool({"pose", folder / "face.fbk", "--out", folder / "x.obj"}).exit_code == 0);
  const std::string text = text_of(folder / "x.obj");
  std::vector<std::string> found;  // lines that are no numbers, and how many polygons follow
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) {
    const std::string line = text.substr(at, text.find('\n', at) - at);
    if (line.starts_with("o ") || line.starts_with("usemtl ")) found.push_back(line);
    if (!line.starts_with("f ")) continue;
    if (!found.back().starts_with("f ")) found.emplace_back("f ");
    found.back() += '+';
  }
  CHECK(found == std::vector<std::string>{"o head", "usemtl skin", "f ++++++", "usemtl none", "f ++++", "o teeth",
                                          "usemtl material1", "f +++++"});
}

}  // namespace test_tool_glb_character
