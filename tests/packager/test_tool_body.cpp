// A head is baked off its body and put back on it: posed by the archive, moved by the joints of the original, and
// compared with the original, frame by frame.
#include <doctest/doctest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "archive/writer.h"
#include "bake/dataset/open_source.h"
#include "bake/rig/source.h"
#include "base/file.h"
#include "gltf_body.h"
#include "gltf_posing.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_body {

using namespace fb;
using namespace fb::test;

namespace {

GltfPose pose_of_frame(std::size_t frame) {
  GltfPose pose;
  for (std::size_t n = GltfBody::hips; n <= GltfBody::eye_joint; ++n)
    pose.locals[GltfBody::names[n]] = GltfBody::matrix(GltfBody::local(n, frame));
  for (std::size_t t = 0; t < GltfBody::targets.size(); ++t)
    pose.weights[GltfBody::targets[t]] = GltfBody::weight(t, frame);
  return pose;
}

std::vector<float> controls_of(const RigSchema& schema, const GltfPose& pose) {
  std::vector<float> controls = schema.rest_pose();
  for (const auto& [name, weight] : pose.weights) controls.at(schema.find(name).value()) = static_cast<float>(weight);
  return controls;
}

// A body in a folder, its archive, and the archive as a glTF file again.
struct BakedBody {
  ScratchFolder folder;
  tinygltf::Model original, again;
  PackedModel face;
  std::vector<std::size_t> vertices;  // of each mesh

  explicit BakedBody(const std::string& recipe) {
    const GltfBody body;
    std::ofstream(folder / "body.glb", std::ios::binary) << body.glb();
    original = load_glb(folder / "body.glb");
    const ToolRun baked = run_tool({"bake", folder / "body.glb", "--recipe", recipe, "--poses", "200", "--epochs", "20",
                                    "--out", folder / "body.fbk"});
    REQUIRE_MESSAGE(baked.exit_code == 0, baked.err);
    face = archive::read_archive(read_file(folder / "body.fbk")).model;
    for (const MeshPart& part : face.rest.parts) vertices.push_back(part.vertices);
    const ToolRun posed = run_tool({"pose", folder / "body.fbk", "--control-targets", "--out", folder / "again.glb"});
    REQUIRE_MESSAGE(posed.exit_code == 0, posed.err);
    again = load_glb(folder / "again.glb");
  }

  // The archive's face in a frame, moved by the original's joints.
  std::vector<double> put_back(const GltfPose& pose) const {
    const std::vector<float> points = evaluate_clip(face, controls_of(face.schema, pose));
    return skinned(face.character, joint_places(face.character, pose.locals), points);
  }
};

double diagonal_of(const std::vector<double>& points) {
  double square = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    double low = points[a], high = points[a];
    for (std::size_t i = a; i < points.size(); i += 3) low = std::min(low, points[i]), high = std::max(high, points[i]);
    square += (high - low) * (high - low);
  }
  return std::sqrt(square);
}

}  // namespace

TEST_CASE("a head that is baked and put back on its body is where the original is, in every frame") {
  const BakedBody baked("linear");
  const std::vector<double> first = posed_points(baked.original, pose_of_frame(0));
  std::vector<double> everywhere = first;
  double moved = 0, worst = 0, worst_again = 0;
  for (std::size_t f = 0; f < GltfBody::frames; ++f) {
    const GltfPose pose = pose_of_frame(f);
    const std::vector<double> expected = posed_points(baked.original, pose);
    everywhere.insert(everywhere.end(), expected.begin(), expected.end());
    moved = std::max(moved, largest_distance(expected, first));
    worst = std::max(worst, largest_distance(baked.put_back(pose), expected));
    worst_again = std::max(worst_again, largest_distance(posed_points(baked.again, pose, baked.vertices), expected));
  }
  MESSAGE("joints move vertices by " << moved << " m in a space of " << diagonal_of(everywhere) << " m; off by at most "
                                     << worst << " m, and by " << worst_again << " m as written to glTF");
  CHECK(moved > 3);
  CHECK(worst < 5e-6 * diagonal_of(everywhere));
  CHECK(worst_again < 5e-6 * diagonal_of(everywhere));
}

TEST_CASE("what joints do is in no displacement, so that the pose of the file does not matter") {
  const BakedBody baked("linear");
  const auto source = bake::open_source(baked.folder / "body.glb");
  REQUIRE(source->clips().size() == 1);
  // The body has no morph targets: it rests while joints move it by metres.
  const bake::Clip& walk = source->clips()[0];
  std::vector<float> points(walk.frames * source->rest().points.size());
  source->read(0, 0, walk.frames, points);
  const std::size_t body = 3 * baked.vertices[0], pose = source->rest().points.size();
  for (std::size_t f = 0; f < walk.frames; ++f)
    for (std::size_t i = 0; i < body; ++i) CHECK(points[f * pose + i] == source->rest().points[i]);
  CHECK(baked.face.rest.diagonal() < 4);

  std::vector<std::string> names;
  for (const Joint& joint : baked.face.character.joints) names.push_back(joint.name);
  CHECK(names == std::vector<std::string>{"Armature", "Hips", "Spine", "Neck", "Head", "EyeJoint"});
  CHECK(baked.face.character.skin.influences == 2);
  CHECK(baked.face.character.joints == source->character().joints);
  CHECK(baked.face.character.skin == source->character().skin);
}

TEST_CASE("a character written to glTF has the skin that it was read with") {
  const BakedBody baked("linear");
  REQUIRE(baked.again.skins.size() == 1);
  CHECK(baked.again.skins[0].joints.size() == 6);
  const tinygltf::Node& head = node_named(baked.again, "Head shape");
  CHECK(head.skin == 0);
  CHECK(head.translation.empty());
  // What Khronos' validator asks of influences.
  for (const tinygltf::Mesh& mesh : baked.again.meshes)
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      const std::vector<std::size_t> joints = joint_numbers(baked.again, primitive.attributes.at("JOINTS_0"));
      const std::vector<float> weights = floats(baked.again, primitive.attributes.at("WEIGHTS_0"));
      CHECK_FALSE(primitive.attributes.contains("JOINTS_1"));
      for (std::size_t v = 0; v < weights.size() / 4; ++v) {
        double sum = 0;
        for (std::size_t i = 4 * v; i < 4 * v + 4; ++i) {
          CHECK((weights[i] > 0 || joints[i] == 0));
          CHECK((weights[i] == 0 || i == 4 * v || joints[i] != joints[i - 1]));
          sum += double(weights[i]);
        }
        CHECK(std::abs(sum - 1) <= 2e-7);
      }
    }
  // At rest it is what the file showed.
  CHECK(largest_distance(posed_points(baked.again, {}, baked.vertices), posed_points(baked.original, {})) < 1e-5);
  const auto first = bake::open_source(baked.folder / "body.glb"),
             second = bake::open_source(baked.folder / "again.glb");
  CHECK(second->character().skin == first->character().skin);
  REQUIRE(second->character().joints.size() == first->character().joints.size());
  for (std::size_t j = 0; j < first->character().joints.size(); ++j) {
    const Joint &a = first->character().joints[j], &b = second->character().joints[j];
    CHECK(a.name == b.name);
    CHECK(a.parent == b.parent);
    for (std::size_t i = 0; i < 12; ++i) {
      CHECK(b.rest[i] == doctest::Approx(a.rest[i]).epsilon(1e-6));
      CHECK(b.inverse_bind[i] == doctest::Approx(a.inverse_bind[i]).epsilon(1e-5));
    }
  }
  const ToolRun shown = run_tool({"inspect", baked.folder / "body.fbk"});
  CHECK_MESSAGE(shown.out.find("EyeJoint |     Head |") != std::string::npos, shown.out);
  CHECK_MESSAGE(shown.out.find("vertices follow joints, at most 2 each") != std::string::npos, shown.out);
}

TEST_CASE("a skeleton is written in metres, with y up, whatever the archive's units") {
  const ScratchFolder folder;
  PackedModel model = body_model();
  model.schema.up_axis = "z";
  for (const bool two_roots : {false, true}) {
    if (two_roots) model.character.joints.push_back({"prop", no_joint, model.character.joints[0].rest, {}});
    const auto bytes = archive::write_archive(model, {});
    write_file(folder / "body.fbk", bytes);
    const PackedModel face = archive::read_archive(bytes).model;
    const ToolRun run = run_tool({"pose", folder / "body.fbk", "--set", "jaw_open=0.5", "--out", folder / "body.glb"});
    REQUIRE_MESSAGE(run.exit_code == 0, run.err);
    const tinygltf::Model written = load_glb(folder / "body.glb");
    std::vector<float> controls = face.schema.rest_pose();
    controls[0] = 0.5f;
    const std::vector<float> posed = evaluate_clip(face, controls);
    GltfPose turned;  // a joint that moves in the file moves as in a host
    turned.locals["jaw"] = GltfBody::matrix({{1, 2, 3}, {0, 0.6, 0.8}, 1, 1});
    for (const GltfPose& pose : {GltfPose{}, turned}) {
      std::vector<double> expected = skinned(face.character, joint_places(face.character, pose.locals), posed);
      for (std::size_t i = 0; i < expected.size(); i += 3) {
        const double y = expected[i + 1];
        expected[i] *= 0.01, expected[i + 1] = 0.01 * expected[i + 2], expected[i + 2] = -0.01 * y;
      }
      CHECK(largest_distance(posed_points(written, pose, {18, 12}), expected) < 1e-6);
    }
    CHECK(written.scenes[0].nodes.size() == (two_roots ? 2 : 3));
    CHECK(node_named(written, "head").mesh == -1);  // the joint; the mesh of that name stands beside
    CHECK(run.err.find("note") == std::string::npos);
  }
}

}  // namespace test_tool_body
