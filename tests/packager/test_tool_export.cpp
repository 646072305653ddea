// export writes what an independent reader of each form plays back as the evaluator poses the face.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "archive/reader.h"
#include "archive/writer.h"
#include "bake/dataset/npy.h"
#include "bake/dataset/point_cache.h"
#include "base/file.h"
#include "glb_reading.h"
#include "gltf_posing.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"
#include "usd_reading.h"

namespace test_tool_export {

using namespace fb;
using namespace fb::test;
using nlohmann::json;

namespace {

// A face in a folder, and a clip of it with the positions of all its frames.
struct ExportedFace {
  ScratchFolder folder;
  PackedModel face;
  std::vector<float> controls, expected;
  std::size_t frames = 0;

  explicit ExportedFace(const PackedModel& model, std::size_t count = 6) : frames(count) {
    archive::ArchiveText text;
    text.licence = "Say \"who\" made it;\nno \\ more.";
    const auto bytes = archive::write_archive(model, {}, text);
    write_file(folder / "face.fbk", bytes);
    face = archive::read_archive(bytes).model;
    controls = write_clip(folder / "clip.npy", face.schema, frames);
    expected = evaluate_clip(face, controls);
  }

  // What --json tells of the export.
  json write(const std::string& name, std::vector<std::string> options) const {
    options.insert(options.begin(), {"export", folder / "face.fbk", folder / name, "--json"});
    const ToolRun run = run_tool(options);
    REQUIRE_MESSAGE(run.exit_code == 0, run.err);
    return json::parse(run.out);
  }
  json write_clip_to(const std::string& name, std::vector<std::string> options = {}) const {
    options.insert(options.end(), {"--clip", folder / "clip.npy", "--fps", "24"});
    return write(name, options);
  }

  std::size_t size() const { return 3 * face.rest.surface_vertex_count(); }
  std::vector<double> frame(std::size_t f) const {
    return {expected.begin() + std::ptrdiff_t(f * size()), expected.begin() + std::ptrdiff_t((f + 1) * size())};
  }
  std::vector<std::size_t> vertices() const {
    std::vector<std::size_t> counts;
    for (const MeshPart& part : face.rest.parts) counts.push_back(part.vertices);
    if (counts.empty()) counts.push_back(face.rest.surface_vertex_count());
    return counts;
  }
};

// Points as the file shows them, in the face's centimetres again.
std::vector<double> shown_points(const tinygltf::Model& model, const GltfPose& pose, const ExportedFace& of) {
  std::vector<double> points = posed_points(model, pose, of.vertices());
  for (double& coordinate : points) coordinate *= 100;
  return points;
}

double largest_error(const tinygltf::Model& model, const ExportedFace& of) {
  double largest = 0;
  for (std::size_t f = 0; f < of.frames; ++f)
    largest = std::max(
        largest,
        largest_distance(shown_points(model, pose_of_animation(model, model.animations.at(0), f), of), of.frame(f)));
  return largest;
}

bool is_near(double a, double b, double share) {
  return std::fabs(a - b) <= share * std::max(a, b);
}

std::vector<std::string> target_names(const tinygltf::Mesh& mesh) {
  std::vector<std::string> names;
  const auto& list = mesh.extras.Get("targetNames");
  for (std::size_t t = 0; t < list.ArrayLen(); ++t) names.push_back(list.Get(int(t)).Get<std::string>());
  return names;
}

std::string text_of(const std::string& path) {
  const auto bytes = read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// The numbers of a line, from `first` on.

}  // namespace

TEST_CASE("blendshapes are the ends of controls, and are exact for one control alone") {
  const ExportedFace of(tiny_packed_model());
  const json figures = of.write("face.glb", {});
  const tinygltf::Model model = load_glb(of.folder / "face.glb");
  CHECK(model.animations.empty());
  const std::vector<std::string> names = target_names(model.meshes.at(0));
  CHECK(figures["shapes"].get<std::vector<std::string>>() == names);
  const std::vector<float> rest = of.face.schema.rest_pose();
  std::size_t ends = 0;
  for (std::size_t c = 0; c < rest.size(); ++c) {
    const Control& control = of.face.schema.controls[c];
    for (const auto& [name, value] :
         {std::pair(control.name, control.maximum), std::pair(control.name + "-", control.minimum)}) {
      std::vector<float> pose = rest;
      pose[c] = value;
      const std::vector<float> expected = evaluate_clip(of.face, pose);
      const bool moves = expected != of.face.rest.points;
      CHECK((std::ranges::count(names, name) == 1) == moves);
      if (!moves) continue;
      ++ends;
      const std::vector<double> shown = shown_points(model, {{}, {{name, 1.0}}}, of);
      CHECK(largest_distance(shown, {expected.begin(), expected.end()}) < 1e-5 * of.face.rest.diagonal());
    }
  }
  CHECK(ends == names.size());
  CHECK(std::ranges::any_of(names, [](const std::string& name) { return name.ends_with("-"); }));
  CHECK(model.asset.extras.Get("licence").Get<std::string>() == "Say \"who\" made it;\nno \\ more.");
  CHECK(figures["shapes_error"]["max_over_diagonal"].get<double>() > 1e-3);  // what controls do in combination
  CHECK(model.asset.extras.Get("shapes_error_max_over_diagonal").GetNumberAsDouble() ==
        doctest::Approx(figures["shapes_error"]["max_over_diagonal"].get<double>()));
}

TEST_CASE("fewer blendshapes are the strongest, and make a larger error") {
  const ExportedFace of(tiny_packed_model());
  const json all = of.write("all.glb", {}), few = of.write("few.glb", {"--shapes", "2"});
  CHECK(few["shapes"].size() == 2);
  CHECK(few["shapes_error"]["rms"].get<double>() > all["shapes_error"]["rms"].get<double>());
  const json none = of.write("none.glb", {"--shapes", "0"});
  CHECK(load_glb(of.folder / "none.glb").meshes.at(0).primitives.at(0).targets.empty());
}

TEST_CASE("a clip plays as it is evaluated, by weights of controls and corrections") {
  for (const PackedModel& face : {tiny_packed_model(), exact_model(), driven_model()}) {
    const ExportedFace of(face, 30);
    for (const char* shapes : {"0", "3", "64"}) {
      CAPTURE(shapes);
      const json figures = of.write_clip_to("clip.glb", {"--shapes", shapes});
      const tinygltf::Model model = load_glb(of.folder / "clip.glb");
      REQUIRE(model.animations.size() == 1);
      const double largest = largest_error(model, of);
      CHECK(largest < 1.1e-5 * of.face.rest.diagonal());
      CHECK(is_near(figures["clip_error"]["max"].get<double>(), largest, 0.3));
      CHECK(figures["frames"] == 30);
    }
  }
}

TEST_CASE("corrections that take more than 256 MB are refused before the work, unless forced") {
  const ExportedFace exported(tiny_packed_model(), 6);
  constexpr std::size_t frames = 10'000;
  const std::vector<float> controls(frames * exported.face.schema.control_count(), 0.5f);
  bake::write_npy(exported.folder / "long.npy", {frames, exported.face.schema.control_count()},
                  std::span<const float>(controls));
  write_file(exported.folder / "face.glb", std::string("precious"));
  const ToolRun run = run_tool({"export", exported.folder / "face.fbk", exported.folder / "face.glb", "--clip",
                                exported.folder / "long.npy", "--tolerance", "0"});
  CAPTURE(run.err);
  CHECK(run.exit_code == 1);
  CHECK(run.err.find("with weights of 10000 frames, would take up to 0.4") != run.err.npos);
  CHECK(run.err.find("--force") != run.err.npos);
  CHECK(read_file(exported.folder / "face.glb").size() == 8);
  CHECK(exported.write_clip_to("face.glb", {"--tolerance", "0", "--force"}).at("frames") == 6);
}

TEST_CASE("joints and blendshapes play a clip with the error that is told") {
  for (const PackedModel& face : {tiny_packed_model(), character_model(), driven_model()}) {
    const ExportedFace of(face, 12);
    const json figures = of.write_clip_to("skin.glb", {"--skinned", "--joints", "4", "--shapes", "2"});
    const tinygltf::Model model = load_glb(of.folder / "skin.glb");
    REQUIRE(model.skins.size() == 1);
    CHECK(model.skins[0].joints.size() == figures["joints"].get<std::size_t>() + 1);  // and the root
    CHECK(figures["shapes"] == 2);
    const double largest = largest_error(model, of), told = figures["error"]["max"].get<double>();
    CHECK(is_near(largest, told, 1e-3));
    const double kept = model.asset.extras.Get("error_max_over_diagonal").GetNumberAsDouble();
    CHECK(is_near(kept * of.face.rest.diagonal(), largest, 1e-3));
    // A blendshape a frame leaves nothing.
    const json enough = of.write_clip_to("enough.glb", {"--skinned", "--joints", "4", "--shapes", "12"});
    CHECK(enough["error"]["max_over_diagonal"].get<double>() < 1e-5);
    CHECK(largest_error(load_glb(of.folder / "enough.glb"), of) < 2e-5 * of.face.rest.diagonal());
    CHECK(told > 1e-4 * of.face.rest.diagonal());
  }
}

TEST_CASE("without a clip there is an animation an end of a control, from rest to there") {
  const ExportedFace of(tiny_packed_model());
  const json figures = of.write("skin.glb", {"--skinned", "--joints", "6", "--shapes", "12"});
  const tinygltf::Model model = load_glb(of.folder / "skin.glb");
  CHECK(model.animations.size() == of.write("face.glb", {})["shapes"].size());  // of those ends that move it
  const auto& rest = of.face.rest.points;
  for (const auto& animation : model.animations) {
    CAPTURE(animation.name);
    CHECK(largest_distance(shown_points(model, pose_of_animation(model, animation, 0), of),
                           {rest.begin(), rest.end()}) < 1e-5 * of.face.rest.diagonal());
    const bool least = animation.name.ends_with("-");
    const std::size_t c = of.face.schema.find(animation.name.substr(0, animation.name.size() - least)).value();
    std::vector<float> pose = of.face.schema.rest_pose();
    pose[c] = least ? of.face.schema.controls[c].minimum : of.face.schema.controls[c].maximum;
    const std::vector<float> expected = evaluate_clip(of.face, pose);
    const double off = largest_distance(shown_points(model, pose_of_animation(model, animation, 1), of),
                                        {expected.begin(), expected.end()}),
                 moved = largest_distance({rest.begin(), rest.end()}, {expected.begin(), expected.end()});
    CHECK(off < 0.2 * moved);
  }
}

TEST_CASE("point caches are read back as they were evaluated, to the last bit") {
  for (const PackedModel& face : {tiny_packed_model(), driven_model()}) {
    const ExportedFace of(face, 70);
    const std::vector<std::size_t> shape = {70, of.face.rest.surface_vertex_count(), 3};
    const auto check = [&](const bake::ArrayFile& file) {
      CHECK(file.shape() == shape);
      std::vector<float> points(of.expected.size());
      file.read(0, 70, points);
      CHECK(points == of.expected);
    };
    CHECK(of.write_clip_to("clip.mdd")["frames"] == 70);
    of.write_clip_to("clip.pc2");
    check(bake::MddFile(of.folder / "clip.mdd"));
    check(bake::Pc2File(of.folder / "clip.pc2"));
    const std::string mdd = text_of(of.folder / "clip.mdd");  // the time of the second frame
    const std::uint32_t bits = __builtin_bswap32(*reinterpret_cast<const std::uint32_t*>(&mdd[12]));
    CHECK(std::bit_cast<float>(bits) == 1.0f / 24);
  }
}

namespace {

void check_usda(const ExportedFace& of) {
  of.write_clip_to("clip.usda");
  const std::string text = text_of(of.folder / "clip.usda");
  CHECK(text.starts_with("#usda 1.0\n(\n"));
  CHECK(text.find("string licence = \"Say \\\"who\\\" made it;\\nno \\\\ more.\"") != std::string::npos);
  CHECK(text.find("timeCodesPerSecond = 24\n") != std::string::npos);
  CHECK(text.find("metersPerUnit = 0.01\n") != std::string::npos);
  for (const auto& [open, close] : {std::pair('{', '}'), std::pair('(', ')'), std::pair('[', ']')})
    CHECK(std::ranges::count(text, open) == std::ranges::count(text, close));
  std::istringstream lines(text);
  std::size_t samples = 0, meshes = 0, first = 0;
  bool points = false;
  for (std::string line; std::getline(lines, line);) {
    line.erase(0, line.find_first_not_of(' '));
    if (line.starts_with("def Mesh")) first = meshes++ == 0 ? 0 : 3 * 18;
    if (line.find("timeSamples") != std::string::npos) points = line.starts_with("point3f[]");
    if (!points || line.find(": [") == std::string::npos) continue;
    const std::size_t f = std::stoul(line);
    const std::vector<float> found = numbers_of(line, line.find('['));
    CHECK(std::equal(found.begin(), found.end(), of.expected.begin() + std::ptrdiff_t(f * of.size() + first)));
    samples += found.size();
  }
  CHECK(meshes == 2);
  CHECK(samples == of.expected.size());
}

}  // namespace

TEST_CASE("a .usda has the polygons, names and licence, and a sample of points a frame") {
  check_usda(ExportedFace(character_model()));
  check_usda(ExportedFace(driven_model()));
}

TEST_CASE("a network has driven joints, and blendshapes say that joints are not in them") {
  const ExportedFace of(driven_model());
  const ToolRun run = run_tool({"export", of.folder / "face.fbk", of.folder / "face.onnx"});
  CHECK(run.exit_code == 0);
  CHECK(run.err.find("joints") == std::string::npos);
  const std::string model = text_of(of.folder / "face.onnx");
  CHECK(model.find("facebaker.joints") != std::string::npos);
  for (const DrivenJoint& joint : of.face.rest.driven.joints)
    CHECK(model.find('"' + joint.name + '"') != std::string::npos);
  for (const std::vector<std::string>& options : {std::vector<std::string>{}, {"--skinned"}}) {
    std::vector<std::string> words = {"export", of.folder / "face.fbk", of.folder / "face.glb"};
    words.insert(words.end(), options.begin(), options.end());
    const ToolRun shapes = run_tool(words);
    CHECK(shapes.exit_code == 0);
    CHECK_MESSAGE(shapes.err.find("4 driven joints are left out") != std::string::npos, shapes.err);
  }
}

TEST_CASE("wrong uses are refused in a sentence and leave nothing behind") {
  const ExportedFace of(tiny_packed_model());
  const std::string face = of.folder / "face.fbk", clip = of.folder / "clip.npy";
  const auto refused = [&](const std::string& out, std::vector<std::string> options, std::vector<std::string> words) {
    options.insert(options.begin(), {"export", face, of.folder / out});
    const ToolRun run = run_tool(options);
    CHECK(run.exit_code == 1);
    CHECK(run.out.empty());
    CHECK_MESSAGE(is_error_line(run.err, "export", words), run.err);
  };
  refused("face.fbx", {}, {"face.fbx", ".glb, .onnx"});
  refused("face.mdd", {}, {"--clip"});
  refused("face.onnx", {"--clip", clip}, {"--clip", ".onnx"});
  refused("face.usda", {"--clip", clip, "--shapes", "3"}, {"--shapes", ".usda"});
  refused("face.glb", {"--joints", "3"}, {"--joints", "--skinned"});
  refused("face.glb", {"--skinned", "--tolerance", "0.1"}, {"--tolerance", "--skinned"});
  refused("face.glb", {"--set", "jaw=1"}, {"jaw", "jaw_open"});
  refused("none/face.pc2", {"--clip", clip}, {"none"});
  CHECK(of.folder.names() == std::vector<std::string>{"clip.npy", "face.fbk"});
}

}  // namespace test_tool_export
