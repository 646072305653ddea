// pose writes driven joints as the skin and the nodes of a glTF file, which an independent reader poses as the
// evaluator does.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "archive/writer.h"
#include "base/file.h"
#include "gltf_body.h"
#include "gltf_posing.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"
#include "turning_joints.h"

namespace test_tool_driven {

using namespace fb;
using namespace fb::test;
using nlohmann::json;

namespace {

// A face with driven joints in a folder, and a clip of it with the positions of its frames.
struct DrivenFace {
  ScratchFolder folder;
  PackedModel face;
  std::size_t frames;
  std::vector<float> controls, expected;

  DrivenFace(const PackedModel& model, std::size_t count) : frames(count) {
    const auto bytes = archive::write_archive(model, {});
    write_file(folder / "face.fbk", bytes);
    face = archive::read_archive(bytes).model;
    controls = write_clip(folder / "clip.npy", face.schema, frames);
    expected = evaluate_clip(face, controls);
  }

  // What --json tells of the file that is written.
  json write(const std::string& name, std::vector<std::string> options, const std::string& note = "") const {
    options.insert(options.begin(), {"pose", folder / "face.fbk", "--out", folder / name, "--json"});
    const ToolRun run = run_tool(options);
    REQUIRE_MESSAGE(run.exit_code == 0, run.err);
    CHECK_MESSAGE(run.err.find(note) != std::string::npos, run.err);
    CHECK(run.err.find("sheared") == std::string::npos);
    return json::parse(run.out);
  }
  json write_clip_to(const std::string& name, std::vector<std::string> options = {}) const {
    options.insert(options.end(), {"--clip", folder / "clip.npy"});
    return write(name, options);
  }

  // The file, with names of targets to pose it by.
  tinygltf::Model load(const std::string& name) const {
    tinygltf::Model model = load_glb(folder / name);
    for (tinygltf::Mesh& mesh : model.meshes) {
      tinygltf::Value::Array names;
      for (std::size_t t = 0; t < mesh.primitives.at(0).targets.size(); ++t)
        names.emplace_back(mesh.name + "." + std::to_string(t));
      mesh.extras = tinygltf::Value(tinygltf::Value::Object{{"targetNames", tinygltf::Value(names)}});
    }
    return model;
  }

  // Positions of frame f in metres with y up, moved by the host's joints, of which `locals` are not at rest.
  std::vector<double> frame(std::size_t f, const std::map<std::string, Place>& locals = {}) const {
    const std::size_t size = 3 * face.rest.surface_vertex_count();
    std::vector<double> points =
        skinned(face.character, joint_places(face.character, locals), std::span(expected).subspan(f * size, size));
    for (std::size_t i = 0; i < points.size(); i += 3) {
      for (std::size_t axis = 0; axis < 3; ++axis) points[i + axis] *= 0.01;
      if (face.schema.up_axis != "z") continue;
      const double y = points[i + 1];
      points[i + 1] = points[i + 2], points[i + 2] = -y;
    }
    return points;
  }

  // The largest distance of the file's points from the evaluated ones, over the diagonal, in all frames.
  double error(const tinygltf::Model& model, const std::map<std::string, Place>& locals = {}) const {
    double largest = 0;
    for (std::size_t f = 0; f < frames; ++f) {
      GltfPose pose = pose_of_animation(model, model.animations.at(0), f);
      pose.locals.insert(locals.begin(), locals.end());
      largest = std::max(largest, largest_distance(posed_points(model, pose, {18, 12}), frame(f, locals)));
    }
    return largest / (0.01 * face.rest.diagonal());
  }
};

std::vector<std::string> animated_parts(const tinygltf::Model& model, const std::string& node) {
  std::vector<std::string> parts;
  for (const auto& channel : model.animations.at(0).channels)
    if (model.nodes.at(std::size_t(channel.target_node)).name == node) parts.push_back(channel.target_path);
  return parts;
}

std::string parent_name(const tinygltf::Model& model, const std::string& name) {
  for (const tinygltf::Node& node : model.nodes)
    for (const int child : node.children)
      if (model.nodes.at(std::size_t(child)).name == name) return node.name;
  return "";
}

void check_weights(const tinygltf::Model& model) {
  for (const tinygltf::Mesh& mesh : model.meshes) {
    const auto& attributes = mesh.primitives.at(0).attributes;
    std::vector<double> sums(model.accessors.at(std::size_t(attributes.at("POSITION"))).count);
    for (std::size_t set = 0; attributes.contains("WEIGHTS_" + std::to_string(set)); ++set) {
      const std::vector<float> weights = floats(model, attributes.at("WEIGHTS_" + std::to_string(set)));
      for (std::size_t i = 0; i < weights.size(); ++i) sums.at(i / 4) += double(weights[i]);
    }
    for (const double sum : sums) CHECK(std::abs(sum - 1) <= 2e-7);
  }
}

}  // namespace

TEST_CASE("a clip of driven joints is nodes that move, a skin, and the few targets that are left") {
  for (const PackedModel& model : {driven_model(), whole_model()}) {
    const DrivenFace of(model, 40);
    const json figures = of.write_clip_to("x.glb");
    const tinygltf::Model file = of.load("x.glb");
    REQUIRE(file.skins.size() == 1);
    CHECK(file.skins[0].joints.size() == 5);  // with the one that stays
    check_weights(file);
    CHECK(parent_name(file, "jaw") == "root");
    CHECK(parent_name(file, "tongue") == "jaw");
    CHECK(parent_name(file, "pin") == "jaw");
    CHECK(parent_name(file, "lid") == "root");
    // The numbers that a joint has, in its parent: jaw turns, tongue turns and moves, pin has none.
    CHECK(animated_parts(file, "jaw") == std::vector<std::string>{"rotation"});
    CHECK(animated_parts(file, "tongue") == std::vector<std::string>{"translation", "rotation"});
    CHECK(animated_parts(file, "pin").empty());
    CHECK(animated_parts(file, "lid") == std::vector<std::string>{"translation", "rotation", "scale"});
    CHECK(figures["driven_joints"] == json{{"count", 4}, {"moving", 3}, {"influences", 4}});
    const double error = of.error(file);
    CHECK(error < 1e-5);
    CHECK(figures["target_error"]["max_over_diagonal"].get<double>() == doctest::Approx(error).epsilon(0.3));
    CHECK(file.meshes[0].primitives[0].targets.size() == figures["targets"]["head"].get<std::size_t>());
    // Without joints a frame is a target.
    const json without = of.write_clip_to("none.glb", {"--driven-joints", "none"});
    CHECK(load_glb(of.folder / "none.glb").skins.empty());
    CHECK_FALSE(without.contains("driven_joints"));
    CHECK(of.error(of.load("none.glb")) < 1e-5);
    CHECK(figures["targets"]["head"].get<std::size_t>() < 0.4 * without["targets"]["head"].get<double>());
  }
}

TEST_CASE("a tolerance is of the targets beside driven joints, and what is off is told") {
  const DrivenFace of(driven_model(), 40);
  for (const char* tolerance : {"0", "0.01"}) {
    CAPTURE(tolerance);
    const json figures = of.write_clip_to("x.glb", {"--tolerance", tolerance});
    const double error = of.error(of.load("x.glb")), told = figures["target_error"]["max_over_diagonal"];
    CHECK(told == doctest::Approx(error).epsilon(error > 1e-4 ? 1e-3 : 0.5));
    CHECK((error > 1e-4) == (std::string(tolerance) != "0"));
  }
}

TEST_CASE(
    "joints that turn below others of uneven scale are where they are; axes that are not at right angles are told") {
  PackedModel model = driven_model();
  auto& joints = model.rest.driven.joints;
  std::swap(joints[0].numbers, joints[3].numbers);  // the jaw has all numbers now
  for (std::size_t n = 6; n < 9; ++n) model.rest.driven.scales[n] /= 16;
  const DrivenFace scaled(model, 40);
  scaled.write_clip_to("x.glb");
  const tinygltf::Model file = scaled.load("x.glb");
  CHECK(animated_parts(file, "jaw") == std::vector<std::string>{"translation", "rotation", "scale"});
  CHECK(animated_parts(file, "tongue") == std::vector<std::string>{"translation", "rotation"});
  CHECK(scaled.error(file) < 1e-5);

  joints[1].rest[0] = 0.5f;  // no writer makes such a frame
  const DrivenFace sheared(model, 40);
  const ToolRun run = run_tool({"pose", sheared.folder / "face.fbk", "--clip", sheared.folder / "clip.npy", "--out",
                                sheared.folder / "x.glb", "--json"});
  REQUIRE_MESSAGE(run.exit_code == 0, run.err);
  CHECK_MESSAGE(run.err.find("sheared within their parents") != std::string::npos, run.err);
  const double error = sheared.error(sheared.load("x.glb"));
  CHECK(error > 1e-4);
  CHECK(json::parse(run.out)["target_error"]["max_over_diagonal"].get<double>() ==
        doctest::Approx(error).epsilon(1e-3));
}

TEST_CASE("joints that turn several times and about pivots are nodes that turn once, and move") {
  for (PackedModel model : {driven_model(), whole_model()}) {
    add_turning_joints(model);
    const DrivenFace of(model, 40);
    const json figures = of.write_clip_to("x.glb");
    const tinygltf::Model file = of.load("x.glb");
    CHECK(figures["driven_joints"]["moving"] == 6);
    CHECK(parent_name(file, "eye") == "tongue");
    CHECK(parent_name(file, "ear") == "brow");
    CHECK(animated_parts(file, "eye") == std::vector<std::string>{"translation", "rotation"});
    CHECK(animated_parts(file, "brow") == std::vector<std::string>{"rotation"});
    CHECK(animated_parts(file, "ear") == std::vector<std::string>{"translation", "rotation", "scale"});
    check_weights(file);
    CHECK(of.error(file) < 1e-5);
  }
}

TEST_CASE("a pose with driven joints has its nodes where they are") {
  const DrivenFace of(driven_model(), 1);
  std::vector<std::string> options;
  for (std::size_t c = 0; c < of.controls.size(); ++c) {
    char value[32];
    std::snprintf(value, sizeof value, "=%.9g", double(of.controls[c]));
    options.insert(options.end(), {"--set", of.face.schema.controls[c].name + value});
  }
  const json posed = of.write("posed.glb", options), rest = of.write("rest.glb", {});
  CHECK(posed["driven_joints"]["moving"] == 3);
  CHECK(rest["driven_joints"]["moving"] == 0);
  const tinygltf::Model file = of.load("posed.glb"), resting = of.load("rest.glb");
  CHECK(file.animations.empty());
  CHECK(largest_distance(posed_points(file, {}, {18, 12}), of.frame(0)) < 1e-5 * 0.01 * of.face.rest.diagonal());
  CHECK(node_named(file, "jaw").rotation != node_named(resting, "jaw").rotation);
  CHECK(floats(resting, resting.meshes[1].primitives[0].attributes.at("POSITION")) ==
        std::vector<float>(of.face.rest.points.begin() + 54, of.face.rest.points.begin() + 90));
}

TEST_CASE("the joints of a host carry driven ones, wherever the host moves them") {
  PackedModel model = body_model();
  drive_joints(model, 1);
  for (const bool whole : {true, false}) {
    // The teeth follow no joint of the host, and stay where it moves the head; or no driven joint either.
    CAPTURE(whole);
    model.schema.up_axis = whole ? "y" : "z";
    for (std::size_t i = 18 * std::size_t(3); i < model.rest.driven.skin.weights.size() && !whole; ++i)
      model.rest.driven.skin.weights[i] = 0, model.rest.driven.skin.joints[i] = 0;
    const DrivenFace of(model, 12);
    of.write("x.glb", {"--clip", of.folder / "clip.npy"}, "vertices follow up to ");
    const tinygltf::Model file = of.load("x.glb");
    REQUIRE(file.skins.size() == 1);
    CHECK(parent_name(file, "jaw") == "head");  // of the host
    CHECK(parent_name(file, "head driven") == "head");
    CHECK(node_named(file, "tongue").mesh == -1);
    CHECK(std::ranges::count(file.nodes, "root", &tinygltf::Node::name) == (whole ? 1 : 0));
    CHECK(of.error(file) < 1e-5);
    const std::map<std::string, Place> turned = {{"head", GltfBody::matrix({{1, 2, 3}, {0, 0.6, 0.8}, 1, 1})},
                                                 {"jaw", GltfBody::matrix({{0, 1, 2}, {0.8, 0, 0.6}, 2, 1})}};
    CHECK(of.error(file, turned) < 3e-5);
  }
}

TEST_CASE("targets of controls take what driven joints do, and say how far that is off") {
  const DrivenFace of(driven_model(), 12);
  const json figures = of.write_clip_to("x.glb", {"--control-targets"});
  const tinygltf::Model file = load_glb(of.folder / "x.glb");
  CHECK(file.skins.empty());
  CHECK(figures["target_error"]["max_over_diagonal"].get<double>() == doctest::Approx(of.error(file)).epsilon(1e-3));
}

TEST_CASE("--driven-joints is for .glb") {
  const DrivenFace of(driven_model(), 1);
  const ToolRun run =
      run_tool({"pose", of.folder / "face.fbk", "--driven-joints", "none", "--out", of.folder / "x.obj"});
  CHECK(run.exit_code == 1);
  CHECK_MESSAGE(is_error_line(run.err, "pose", {"--driven-joints", ".glb"}), run.err);
}

}  // namespace test_tool_driven
