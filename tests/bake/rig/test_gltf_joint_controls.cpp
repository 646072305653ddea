// Joints of glTF files as controls: positions are what the file shows, by the rules of glTF, in the poses of its
// animations and in others.
#include <cmath>
#include <fstream>
#include <numbers>

#include "bake/rig/driven_pose.h"
#include "bake/rig/gltf/gltf_rig.h"
#include "bake_test_support.h"
#include "gltf_avatar.h"
#include "gltf_posing.h"

namespace test_gltf_joint_controls {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;
using nlohmann::json;

namespace {

OpenedSource open(const GltfAvatar& avatar, const GltfOptions& options) {
  const std::string bytes = avatar.glb();
  return open_gltf_rig(std::as_bytes(std::span(bytes)), "avatar", options);
}

const GltfOptions controls_of_joints = {JointUse::controls, {}};

// A transform in parts, as a matrix: scale, then rotation (x, y, z, w), then translation.
Place place_of_parts(const std::array<double, 3>& translation, const std::array<double, 4>& rotation,
                     const std::array<double, 3>& scale = {1, 1, 1}) {
  tinygltf::Node node;
  node.translation.assign(translation.begin(), translation.end());
  node.rotation.assign(rotation.begin(), rotation.end());
  node.scale.assign(scale.begin(), scale.end());
  return local_place(node);
}

std::array<double, 4> turn(const std::array<double, 3>& axis, double degrees) {
  const double half = degrees * std::acos(-1.0) / 360;
  return {axis[0] * std::sin(half), axis[1] * std::sin(half), axis[2] * std::sin(half), std::cos(half)};
}

std::array<double, 4> times_turn(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] + a[1] * b[3] + a[2] * b[0] - a[0] * b[2],
          a[3] * b[2] + a[2] * b[3] + a[0] * b[1] - a[1] * b[0], a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
}

// What the file shows in a pose.
std::vector<double> shown_points(const GltfAvatar& avatar, const GltfPose& pose) {
  const Folder folder;
  std::ofstream(folder / "file.glb", std::ios::binary) << avatar.glb();
  return posed_points(load_glb((folder / "file.glb").string()), pose);
}

double distance_from_shown(Source& rig, const std::vector<float>& controls, const GltfAvatar& avatar,
                           const GltfPose& pose) {
  std::vector<float> points(rig.rest().points.size());
  rig.evaluate(controls, 1, points);
  points.resize(3 * rig.rest().surface_vertex_count());
  return largest_distance({points.begin(), points.end()}, shown_points(avatar, pose));
}

std::vector<float> with_values(const Source& rig, const std::map<std::string, double>& values) {
  std::vector<float> controls = rig.schema().rest_pose();
  for (const auto& [name, value] : values) controls.at(rig.schema().find(name).value()) = static_cast<float>(value);
  return controls;
}

std::vector<std::string> control_names(const Source& rig) {
  std::vector<std::string> names;
  for (const Control& control : rig.schema().controls) names.push_back(control.name);
  return names;
}

// An animation of one channel.
void animate(GltfAvatar& avatar, const std::string& name, int node, const char* path, const std::vector<float>& times,
             const std::vector<float>& values, const char* interpolation) {
  const std::size_t width = std::string(path) == "rotation" ? 4 : 3;
  const json sampler = {{"input", avatar.more().accessor(times, "SCALAR", 1)},
                        {"output", avatar.more().accessor(values, width == 4 ? "VEC4" : "VEC3", width)},
                        {"interpolation", interpolation}};
  for (json& animation : avatar.json["animations"])
    if (animation["name"] == name) {
      animation["channels"].push_back(
          {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
      animation["samplers"].push_back(sampler);
      return;
    }
  avatar.json["animations"].push_back({{"name", name},
                                       {"samplers", {sampler}},
                                       {"channels", {{{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}}}}});
}

std::string refused(const GltfAvatar& avatar, const GltfOptions& options, Status status) {
  return failure(status, [&] { open(avatar, options); });
}

}  // namespace

TEST_CASE("joints that animations move are controls behind the morph targets") {
  const GltfAvatar avatar;
  const auto rig = open(avatar, controls_of_joints);
  CHECK(control_names(*rig) ==
        std::vector<std::string>{"jawOpen", "browInnerUp", "mouthSmileLeft", "tongueOut", "Neck.rz", "Head.rz"});
  // At rest the neck is turned by 30 degrees, the head by -20; animations turn both from 0 to 180.
  const Control &neck = rig->schema().controls[4], &head = rig->schema().controls[5];
  CHECK(neck.minimum == doctest::Approx(-30));
  CHECK(neck.maximum == doctest::Approx(150));
  CHECK(std::abs(head.minimum) < 1e-5f);
  CHECK(head.maximum == doctest::Approx(200));
  CHECK(neck.rest == 0);
  CHECK(neck.group == "Neck");
  CHECK(neck.labels.unit == "degrees");
  CHECK(rig->character().joints.empty());
  CHECK(rig->character().skin.influences == 0);
  CHECK(distance_from_shown(*rig, rig->schema().rest_pose(), avatar, {}) < 2e-6);
  const auto unskinned = open(avatar, {});
  CHECK(rig->rest().points != unskinned->rest().points);
  CHECK(rig->version() != unskinned->version());

  GltfPose pose;
  pose.weights = {{"jawOpen", 0.5}, {"tongueOut", 1}};
  pose.locals["Neck"] = place_of_parts({0, 1, 0}, turn({0, 0, 1}, 30 + 100));
  pose.locals["Head"] = place_of_parts({0, 0.5, 0.25}, turn({0, 0, 1}, -20 + 45));
  CHECK(distance_from_shown(*rig,
                            with_values(*rig, {{"jawOpen", 0.5}, {"tongueOut", 1}, {"Neck.rz", 100}, {"Head.rz", 45}}),
                            avatar, pose) < 5e-6);
}

TEST_CASE("joints that are controls are driven joints of the face") {
  const auto rig = open(GltfAvatar(), controls_of_joints);
  const Mesh& rest = rig->rest();
  REQUIRE(rest.driven.joints.size() >= 2);
  CHECK(rest.driven.joints[0].name == "Neck");
  CHECK(rest.driven.joints[0].parent == no_joint);
  CHECK(rest.driven.joints[0].numbers == 4);  // about z
  CHECK(rest.driven.joints[1].name == "Head");
  CHECK(rest.driven.joints[1].parent == 0);
  const std::vector<float> pose = with_values(*rig, {{"jawOpen", 0.5}, {"Neck.rz", 100}, {"Head.rz", 15}});
  std::vector<float> points(rest.points.size()), of_weight(points.size());
  rig->evaluate(pose, 1, points);
  const std::size_t first = rest.first_joint_coordinate();
  CHECK(rest.driven.scales[0] * points[first] == doctest::Approx(100 * std::numbers::pi / 180));
  CHECK(rest.driven.scales[1] * points[first + 1] == doctest::Approx(15 * std::numbers::pi / 180));
  // What they leave of vertices that follow one of them is what the morph target does alone.
  rig->evaluate(with_values(*rig, {{"jawOpen", 0.5}}), 1, of_weight);
  points_to_displacements(rest, points);
  points_to_displacements(rest, of_weight);
  std::size_t alone = 0;
  for (std::size_t v = 0; v < rest.surface_vertex_count(); ++v) {
    if (rest.driven.skin.weights[v * rest.driven.skin.influences] != 1) continue;
    ++alone;
    for (std::size_t i = 3 * v; i < 3 * v + 3; ++i) CHECK(std::abs(points[i] - of_weight[i]) < 5e-6f);
  }
  CHECK(alone > 10);
}

TEST_CASE("frames of clips with joints are what the file shows at their times") {
  const GltfAvatar avatar;
  const auto rig = open(avatar, controls_of_joints);
  REQUIRE(rig->clips().size() == 2);
  const Clip &talk = rig->clips()[0], &nod = rig->clips()[1];
  CHECK(talk.name == "talk");
  CHECK(nod.frames == 31);
  const std::size_t width = rig->schema().control_count();
  const auto frame = [&](const Clip& clip, std::size_t f) {
    return std::vector<float>(clip.controls.begin() + static_cast<std::ptrdiff_t>(f * width),
                              clip.controls.begin() + static_cast<std::ptrdiff_t>((f + 1) * width));
  };
  for (const std::size_t f : {0, 1, 10, 17, 30}) {
    GltfPose pose;
    pose.locals["Head"] = place_of_parts({0, 0.5, 0.25}, turn({0, 0, 1}, 6.0 * double(f)));
    CAPTURE(f);
    CHECK(distance_from_shown(*rig, frame(nod, f), avatar, pose) < 5e-6);
  }
  GltfPose pose;  // at a tenth of a second
  pose.locals["Neck"] = place_of_parts({0, 1, 0}, turn({0, 0, 1}, 90));
  pose.weights = {{"jawOpen", 0.5}, {"browInnerUp", 0.25}, {"mouthSmileLeft", 0.125}};
  std::vector<float> controls = frame(talk, 3);
  controls[rig->schema().find("tongueOut").value()] = 0;
  CHECK(distance_from_shown(*rig, controls, avatar, pose) < 5e-6);
  // The tongue's weights step: each is held up to the next key, at 0.1 and 0.3 s, and the neck goes on meanwhile.
  const std::size_t tongue = rig->schema().find("tongueOut").value(), neck = rig->schema().find("Neck.rz").value();
  for (std::size_t f = 0; f + 1 < talk.frames; ++f) {
    CHECK((frame(talk, f)[tongue] != frame(talk, f + 1)[tongue]) == (f + 1 == 9));
    CHECK((frame(talk, f)[neck] != frame(talk, f + 1)[neck]) == (f + 1 <= 6));
  }
}

TEST_CASE("translations, scales and rotations around any axis go through all kinds of keys") {
  GltfAvatar avatar;
  avatar.json["animations"] = json::array();
  const std::array<double, 3> axis = {0.6, 0, -0.8}, other = {0.48, 0.6, 0.64};
  const auto first = times_turn(turn({0, 0, 1}, -20), turn(axis, 70)),
             second = times_turn(turn({0, 0, 1}, -20), turn(other, -110));
  std::vector<float> turns, cubic;
  for (const auto& q : {first, second})
    for (const double x : q) turns.push_back(static_cast<float>(x));
  for (const float x : {0.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 1.f, 2.f, 0.5f, 0.f, 0.f, 0.f})
    cubic.push_back(x);  // no tangents: half way is half
  animate(avatar, "all", GltfAvatar::head, "rotation", {0, 1}, turns, "STEP");
  animate(avatar, "all", GltfAvatar::head, "scale", {0, 1}, {1, 1, 1, 2, 0.5f, 1}, "LINEAR");
  animate(avatar, "all", GltfAvatar::neck, "translation", {0, 1}, cubic, "CUBICSPLINE");
  const auto rig = open(avatar, controls_of_joints);
  CHECK(control_names(*rig) == std::vector<std::string>{"jawOpen", "browInnerUp", "mouthSmileLeft", "tongueOut",
                                                        "Neck.tx", "Neck.ty", "Neck.tz", "Head.rx", "Head.ry",
                                                        "Head.rz", "Head.sx", "Head.sy"});
  CHECK(rig->schema().controls[4].labels.unit == "m");
  const Clip& clip = rig->clips().at(0);
  const std::size_t width = rig->schema().control_count();
  for (const std::size_t f : {0, 15, 29, 30}) {
    const double t = double(f) / 30, ease = 3 * t * t - 2 * t * t * t;
    GltfPose pose;
    pose.locals["Neck"] = place_of_parts({ease, 1 + ease, 0.5 * ease}, turn({0, 0, 1}, 30));
    pose.locals["Head"] = place_of_parts({0, 0.5, 0.25}, f < 30 ? first : second, {1 + t, 1 - 0.5 * t, 1});
    const std::vector<float> frame(clip.controls.begin() + static_cast<std::ptrdiff_t>(f * width),
                                   clip.controls.begin() + static_cast<std::ptrdiff_t>((f + 1) * width));
    CAPTURE(f);
    CHECK(distance_from_shown(*rig, frame, avatar, pose) < 1e-5);
  }
  // Between: a rotation vector of 50 degrees around the first axis.
  GltfPose pose;
  pose.locals["Head"] = place_of_parts({0, 0.5, 0.25}, times_turn(turn({0, 0, 1}, -20), turn(axis, 50)));
  CHECK(distance_from_shown(*rig, with_values(*rig, {{"Head.rx", 50 * axis[0]}, {"Head.rz", 50 * axis[2]}}), avatar,
                            pose) < 1e-5);
}

TEST_CASE("rotations go on beyond half a turn, to three quarters of one") {
  GltfAvatar avatar;
  avatar.json["animations"] = json::array();
  std::vector<float> times, turns;
  for (int k = 0; k <= 20; ++k) {
    times.push_back(float(k) / 10);
    for (const double x : turn({0, 0, 1}, -20 + 45.0 * k)) turns.push_back(static_cast<float>(x));
  }
  animate(avatar, "spin", GltfAvatar::head, "rotation", times, turns, "LINEAR");
  const auto rig = open(avatar, controls_of_joints);
  const std::size_t head = rig->schema().find("Head.rz").value(), width = rig->schema().control_count();
  const Clip& clip = rig->clips().at(0);
  CHECK(clip.controls[15 * width + head] == doctest::Approx(225));
  CHECK(clip.controls[21 * width + head] == doctest::Approx(-45));
  CHECK(clip.controls[27 * width + head] == doctest::Approx(45));
  CHECK(clip.controls[36 * width + head] == doctest::Approx(180));
  CHECK(rig->schema().controls[head].maximum <= 270.01f);
  CHECK(rig->schema().controls[head].minimum >= -180.01f);
}

TEST_CASE("joints are chosen by name, and others stay at rest") {
  const GltfAvatar avatar;
  const auto rig = open(avatar, {JointUse::automatic, {"EyeLeft", "Head"}});
  // No animation turns the eye.
  CHECK(control_names(*rig) == std::vector<std::string>{"jawOpen", "browInnerUp", "mouthSmileLeft", "tongueOut",
                                                        "Head.rz", "EyeLeft.rx", "EyeLeft.ry", "EyeLeft.rz"});
  CHECK(rig->schema().controls[5].minimum == -30);
  CHECK(rig->schema().controls[5].maximum == 30);
  GltfPose pose;
  pose.locals["EyeLeft"] = times(local_place(load_glb([&] {
                                               static const Folder folder;
                                               std::ofstream(folder / "f.glb", std::ios::binary) << avatar.glb();
                                               return (folder / "f.glb").string();
                                             }())
                                                 .nodes[GltfAvatar::left_eye]),
                                 place_of_parts({0, 0, 0}, turn({0, 1, 0}, 25)));
  CHECK(distance_from_shown(*rig, with_values(*rig, {{"EyeLeft.ry", 25}}), avatar, pose) < 5e-6);

  CHECK(contains(refused(avatar, {JointUse::automatic, {"Haed"}}, Status::not_found), "no joint or node \"Haed\""));
  CHECK(contains(refused(avatar, {JointUse::controls, {"Hidden"}}, Status::bad_data),
                 "joint \"Hidden\" moves no vertex"));
  CHECK(contains(refused(avatar, {JointUse::ignored, {"Head"}}, Status::invalid_argument), "joints are ignored"));
  GltfAvatar sheared;
  sheared.json["nodes"][GltfAvatar::left_eye]["matrix"][4] = 0.5;
  CHECK(contains(refused(sheared, {JointUse::controls, {"EyeLeft"}}, Status::unsupported),
                 "the matrix of joint \"EyeLeft\" shears or flattens"));
  GltfAvatar still;
  still.json.erase("animations");
  CHECK(contains(refused(still, controls_of_joints, Status::bad_data), "no animation moves a joint"));
}

TEST_CASE("without morph targets, joints that move are controls unless they are to be ignored") {
  GltfAvatar avatar;
  for (json& mesh : avatar.json["meshes"]) {
    for (json& primitive : mesh["primitives"]) primitive.erase("targets");
    mesh.erase("extras");
  }
  avatar.json["animations"].erase(0);
  const auto rig = open(avatar, {});
  CHECK(control_names(*rig) == std::vector<std::string>{"Head.rz"});
  CHECK(contains(refused(avatar, {JointUse::ignored, {}}, Status::bad_data), "shows no mesh with morph targets"));

  // Without skins too: nodes with meshes on them, or below.
  avatar.json.erase("skins");
  for (json& node : avatar.json["nodes"]) node.erase("skin");
  const auto rigid = open(avatar, {});
  GltfPose pose;
  pose.locals["Head"] = place_of_parts({0, 0.5, 0.25}, turn({0, 0, 1}, -20 + 60));
  CHECK(distance_from_shown(*rigid, with_values(*rigid, {{"Head.rz", 60}}), avatar, pose) < 5e-6);
}

}  // namespace test_gltf_joint_controls
