// pose and the sample pose_face write glTF from which an independent reader gets the evaluator's positions.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "archive/writer.h"
#include "bake/dataset/open_source.h"
#include "bake/rig/source.h"
#include "base/file.h"
#include "glb_reading.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_glb {

namespace {

void check_unit_length(const std::vector<float>& normals) {
  for (std::size_t v = 0; v < normals.size(); v += 3)
    CHECK(std::hypot(normals[v], normals[v + 1], normals[v + 2]) == doctest::Approx(1).epsilon(1e-4));
}

// The animation played as the glTF specification says: morph targets weighted and added to the base.
void check_animation(std::size_t frames, std::size_t largest_target_count) {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", clip = folder / "clip.npy", out = folder / "clip.glb";
  const fb::PackedModel face = write_tiny_archive(archive);
  const auto expected = evaluate_clip(face, write_clip(clip, face.schema, frames));
  REQUIRE(run_tool({"pose", archive, "--clip", clip, "--fps", "24", "--out", out}).exit_code == 0);
  const tinygltf::Model model = load_glb(out);
  const auto& primitive = model.meshes.at(0).primitives.at(0);
  const std::size_t targets = primitive.targets.size(), size = face.rest.points.size();
  REQUIRE(targets > 0);
  CHECK(targets <= largest_target_count);
  CHECK(model.meshes[0].weights.size() == targets);
  const auto& animation = model.animations.at(0);
  CHECK(animation.channels.at(0).target_path == "weights");
  const auto times = floats(model, animation.samplers.at(0).input);
  const auto weights = floats(model, animation.samplers.at(0).output);
  REQUIRE(times.size() == frames);
  REQUIRE(weights.size() == frames * targets);
  CHECK(times[frames - 1] == doctest::Approx((frames - 1) / 24.0));
  for (std::size_t t = 0; t < targets; ++t) CHECK(model.meshes[0].weights[t] == weights[t]);  // the first frame's
  const auto base = floats(model, primitive.attributes.at("POSITION")),
             normals = floats(model, primitive.attributes.at("NORMAL"));
  check_unit_length(normals);
  std::vector<std::vector<float>> moves, turns;
  for (const auto& target : primitive.targets) {
    moves.push_back(floats(model, target.at("POSITION")));
    turns.push_back(floats(model, target.at("NORMAL")));
  }
  for (std::size_t f = 0; f < frames; ++f) {
    std::vector<float> points = base, bent = normals;
    for (std::size_t t = 0; t < targets; ++t)
      for (std::size_t i = 0; i < size; ++i) {
        points[i] += weights[f * targets + t] * moves[t][i];
        bent[i] += weights[f * targets + t] * turns[t][i];
      }
    // The evaluator rounds coefficients to 16 bits, a viewer does not.
    CHECK(largest_difference(points.data(), &expected[f * size], size) < 2e-5 * face.rest.diagonal());
    if (targets == frames) check_unit_length(bent);
  }
}

}  // namespace

TEST_CASE("a pose becomes one mesh with every vertex in order, normals and triangles") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", out = folder / "pose.glb";
  const fb::PackedModel face = write_tiny_archive(archive);
  REQUIRE(run_tool({"pose", archive, "--set", "jaw_open=1", "--out", out}).exit_code == 0);
  auto controls = face.schema.rest_pose();
  controls[0] = 1;
  const tinygltf::Model model = load_glb(out);
  CHECK(model.asset.version == "2.0");
  CHECK(model.animations.empty());
  CHECK(model.nodes.at(0).scale == std::vector<double>(3, 0.01));  // centimetres
  const auto& primitive = model.meshes.at(0).primitives.at(0);
  CHECK(floats(model, primitive.attributes.at("POSITION")) == evaluate_clip(face, controls));
  check_unit_length(floats(model, primitive.attributes.at("NORMAL")));
  const auto& indices = model.accessors.at(primitive.indices);
  CHECK(view_values<std::uint32_t>(model, indices.bufferView, 0, indices.count) == face.rest.triangles());
}

TEST_CASE("a face in other units, with z up, is upright and in metres") {
  const ScratchFolder folder;
  fb::PackedModel face = fb::tiny_packed_model();
  face.schema.units = "mm";
  face.schema.up_axis.assign(1, 'z');
  fb::write_file(folder / "face.fbk", fb::archive::write_archive(face, {}));
  REQUIRE(run_tool({"pose", folder / "face.fbk", "--out", folder / "pose.glb"}).exit_code == 0);
  const tinygltf::Model model = load_glb(folder / "pose.glb");
  const tinygltf::Node& node = model.nodes.at(0);
  CHECK(node.scale == std::vector<double>(3, 0.001));
  REQUIRE(node.rotation.size() == 4);
  const double x = node.rotation[0], w = node.rotation[3];  // about x: z becomes (0, -2 x w, w w - x x)
  CHECK(node.rotation[1] == 0);
  CHECK(node.rotation[2] == 0);
  CHECK(-2 * x * w == doctest::Approx(1));
  CHECK(w * w - x * x == doctest::Approx(0));
}

TEST_CASE("a short clip becomes its frames as morph targets") {
  check_animation(4, 4);
}

TEST_CASE("a long clip becomes the basis as morph targets") {
  check_animation(40, 5);
}

TEST_CASE("an exported animation opens as a rig with the same motion, in metres") {
  for (const std::size_t frames : {4, 40}) {
    CAPTURE(frames);
    const ScratchFolder folder;
    const std::string archive = folder / "face.fbk", clip = folder / "clip.npy", out = folder / "clip.glb";
    const fb::PackedModel face = write_tiny_archive(archive);
    std::vector<float> expected = evaluate_clip(face, write_clip(clip, face.schema, frames));
    for (float& coordinate : expected) coordinate *= 0.01f;
    REQUIRE(run_tool({"pose", archive, "--clip", clip, "--fps", "30", "--out", out}).exit_code == 0);
    const auto rig = fb::bake::open_source(out);
    CHECK(rig->schema().control_count() == load_glb(out).meshes.at(0).primitives.at(0).targets.size());
    CHECK(rig->schema().controls[0].name == "target0");
    REQUIRE(rig->clips().size() == 1);
    REQUIRE(rig->clips()[0].frames == frames);
    std::vector<float> points(expected.size());
    rig->read(0, 0, frames, points);
    CHECK(largest_difference(points.data(), expected.data(), points.size()) < 2e-5 * rig->rest().diagonal());
    CHECK(largest_difference(rig->rest().points.data(), expected.data(), rig->rest().points.size()) <
          2e-5 * rig->rest().diagonal());  // it rests where it begins
  }
}

TEST_CASE("a .glb has the texture coordinates of every corner, with copies of vertices on seams") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", clip = folder / "clip.npy", out = folder / "clip.glb";
  fb::PackedModel face = fb::tiny_packed_model();
  fb::give_uvs(face.rest);
  fb::write_file(archive, fb::archive::write_archive(face, {}));
  write_clip(clip, face.schema, 4);
  REQUIRE(run_tool({"pose", archive, "--clip", clip, "--out", out}).exit_code == 0);
  const tinygltf::Model model = load_glb(out);
  const auto& primitive = model.meshes.at(0).primitives.at(0);
  const auto points = floats(model, primitive.attributes.at("POSITION")),
             uvs = floats(model, primitive.attributes.at("TEXCOORD_0"));
  const std::size_t vertices = face.rest.vertex_count(), all = points.size() / 3;
  CHECK(all > vertices);
  CHECK(uvs.size() == 2 * all);
  CHECK(floats(model, primitive.attributes.at("NORMAL")).size() == 3 * all);
  for (const auto& target : primitive.targets) CHECK(floats(model, target.at("POSITION")).size() == 3 * all);
  const auto& indices = model.accessors.at(primitive.indices);
  const auto corners = view_values<std::uint32_t>(model, indices.bufferView, 0, indices.count);
  fb::Mesh pairs = face.rest;
  pairs.polygon_corners = face.rest.uv_corners;
  const auto vertex = face.rest.triangles(), pair = pairs.triangles();
  REQUIRE(corners.size() == vertex.size());
  for (std::size_t c = 0; c < corners.size(); ++c) {
    CAPTURE(c);
    for (std::size_t axis = 0; axis < 3; ++axis) CHECK(points[3 * corners[c] + axis] == points[3 * vertex[c] + axis]);
    CHECK(uvs[2 * corners[c]] == face.rest.uvs[2 * pair[c]]);
    CHECK(uvs[2 * corners[c] + 1] == 1 - face.rest.uvs[2 * pair[c] + 1]);
  }
}

TEST_CASE("the sample pose_face writes the same mesh through the C API") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", out = folder / "pose.glb";
  const fb::PackedModel face = write_tiny_archive(archive);
  REQUIRE(run_program(FB_POSE_FACE, {archive, out, "jaw_open=1"}).exit_code == 0);
  auto controls = face.schema.rest_pose();
  controls[0] = 1;
  const tinygltf::Model model = load_glb(out);
  const auto& primitive = model.meshes.at(0).primitives.at(0);
  CHECK(floats(model, primitive.attributes.at("POSITION")) == evaluate_clip(face, controls));
  check_unit_length(floats(model, primitive.attributes.at("NORMAL")));
  const auto& indices = model.accessors.at(primitive.indices);
  CHECK(view_values<std::uint32_t>(model, indices.bufferView, 0, indices.count) == face.rest.triangles());
  const ToolRun misspelt = run_program(FB_POSE_FACE, {archive, folder / "x.glb", "jaw_opne=1"});
  CHECK(misspelt.exit_code == 1);
  CHECK(misspelt.err.find("jaw_open") != std::string::npos);
}

}  // namespace test_tool_glb
