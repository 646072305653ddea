// pose: controls from the command line, and what .obj and .png hold.
#include <doctest/doctest.h>

#include <cmath>
#include <sstream>

#include "archive/writer.h"
#include "bake/dataset/npy.h"
#include "base/file.h"
#include "picture_reading.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_pose {

namespace {

struct Obj {
  std::vector<float> points;
  std::vector<std::vector<std::uint32_t>> polygons;
};

std::string text_of(const std::string& path) {
  const auto bytes = fb::read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Obj read_obj(const std::string& path) {
  Obj obj;
  std::istringstream lines(text_of(path));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "v")
      for (float value; words >> value;) obj.points.push_back(value);
    if (kind == "f") {
      obj.polygons.emplace_back();
      for (std::uint32_t corner; words >> corner;) obj.polygons.back().push_back(corner - 1);
    }
  }
  return obj;
}

}  // namespace

TEST_CASE("an .obj has exactly the evaluated points and the rig's own polygons") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", out = folder / "pose.obj";
  const fb::PackedModel model = write_tiny_archive(archive);
  const ToolRun run = run_tool({"pose", "--set", "jaw_open=0.75", archive, "--set", "mouth_side=-0.5", "--out", out});
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  CHECK(run.out == out + "\n");
  CHECK(run.err.empty());
  auto controls = model.schema.rest_pose();
  controls[0] = 0.75f;
  controls[1] = -0.5f;
  const Obj obj = read_obj(out);
  CHECK(obj.points == evaluate_clip(model, controls));
  REQUIRE(obj.polygons.size() == model.rest.polygon_sizes.size());
  const std::uint32_t* corner = model.rest.polygon_corners.data();
  for (const auto& polygon : obj.polygons)
    for (const std::uint32_t vertex : polygon) CHECK(vertex == *corner++);
}

TEST_CASE("an .obj has the texture coordinates of every corner") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", out = folder / "rest.obj";
  fb::PackedModel model = fb::tiny_packed_model();
  model.rest.uvs = {0, 0, 1, 0.25f, 0.5f, 1};
  for (std::size_t c = 0; c < model.rest.polygon_corners.size(); ++c)
    model.rest.uv_corners.push_back(static_cast<std::uint32_t>(c % 3));
  fb::write_file(archive, fb::archive::write_archive(model, {}));
  REQUIRE(run_tool({"pose", archive, "--out", out}).exit_code == 0);
  const std::string text = text_of(out);
  CHECK(text.find("\nvt 0 0\nvt 1 0.25\nvt 0.5 1\n") != std::string::npos);
  CHECK(text.find("\nf 1/1 2/2 8/3 7/1\nf 2/2 3/3 9/1 8/2\n") != std::string::npos);
}

TEST_CASE("without --set the face is at rest") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", out = folder / "rest.obj";
  const fb::PackedModel model = write_tiny_archive(archive);
  REQUIRE(run_tool({"pose", archive, "--out", out}).exit_code == 0);
  CHECK(read_obj(out).points == model.rest.points);
}

TEST_CASE("a value out of range is clamped, with a note") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", over = folder / "over.obj", full = folder / "full.obj";
  write_tiny_archive(archive);
  const ToolRun run = run_tool({"pose", archive, "--set", "jaw_open=1.5", "--out", over});
  CHECK(run.exit_code == 0);
  CHECK(is_error_line(run.err, "pose", {"jaw_open", "1.5", "0 to 1", "clamped"}));
  REQUIRE(run_tool({"pose", archive, "--set", "jaw_open=1", "--out", full}).exit_code == 0);
  CHECK(read_obj(over).points == read_obj(full).points);
  const ToolRun two = run_tool({"pose", archive, "--set", "jaw_open=2", "--set", "lid_close=-1", "--set",
                                "mouth_side=1", "--out", over, "--json"});
  REQUIRE(two.exit_code == 0);
  CHECK(two.out.find("\"clamped\": 2") != std::string::npos);
}

TEST_CASE("invalid settings are refused by name and leave no file") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", out = folder / "x.obj";
  write_tiny_archive(archive);
  const auto refused_as = [&](const std::string& file, std::vector<std::string> options,
                              const std::vector<std::string>& words) {
    std::vector<std::string> arguments = {"pose", archive, "--out", file};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ToolRun run = run_tool(arguments);
    CAPTURE(run.err);
    CHECK(run.exit_code == 1);
    CHECK(is_error_line(run.err, "pose", words));
    CHECK(folder.names() == std::vector<std::string>{"face.fbk"});
  };
  const auto refused = [&](std::vector<std::string> options, const std::vector<std::string>& words) {
    refused_as(out, std::move(options), words);
  };
  refused({"--set", "JawOpen=1"}, {"JawOpen", "jaw_open"});
  refused({"--set", "lid_clsoe=1"}, {"lid_clsoe", "lid_close"});
  refused({"--set", "jaw_open"}, {"jaw_open", "NAME=VALUE"});
  refused({"--set", "jaw_open=wide"}, {"jaw_open=wide", "not a number"});
  refused({"--set", "jaw_open=nan"}, {"not a number"});
  refused({"--set", "jaw_open=1e999"}, {"not a number"});
  refused_as(folder / "x.fbx", {}, {".glb", ".obj", ".png"});
  refused({"--frame", "0"}, {"--frame", "--clip"});
  refused({"--beside", FB_TOY_RIG}, {"--beside", ".png"});
  refused_as(folder / "x.png", {"--size", "0x100"}, {"--size"});
  refused_as(folder / "x.png", {"--size", "100"}, {"--size"});
  refused_as(folder / "x.png", {"--beside", FB_TOY_RIG}, {FB_TOY_RIG});
  refused_as(folder / "x.png", {"--beside", folder / "librig_none.so"}, {"librig_none.so"});
}

TEST_CASE("clips that do not fit are refused by file, frame and control") {
  const ScratchFolder folder, clips;
  const std::string archive = folder / "face.fbk", out = folder / "x.obj";
  const fb::PackedModel model = write_tiny_archive(archive);
  const auto refused = [&](const std::string& clip, const std::vector<std::string>& words) {
    const ToolRun run = run_tool({"pose", archive, "--out", out, "--clip", clip});
    CAPTURE(run.err);
    CHECK(run.exit_code == 1);
    CHECK(is_error_line(run.err, "pose", words));
    CHECK(folder.names() == std::vector<std::string>{"face.fbk"});
  };
  const auto write = [&](const char* name, const std::vector<std::size_t>& shape, const std::vector<float>& values) {
    fb::bake::write_npy(clips / name, shape, std::span<const float>(values));
    return clips / name;
  };
  refused(clips / "missing.npy", {"missing.npy", "no such file"});
  refused(archive, {archive});
  refused(write("narrow.npy", {3, 4}, std::vector<float>(12)), {"narrow.npy", "(3, 4)", "5"});
  refused(write("flat.npy", {5}, std::vector<float>(5)), {"flat.npy"});
  refused(write("none.npy", {0, 5}, {}), {"none.npy"});
  std::vector<float> values(15);
  values[1 * 5 + 3] = NAN;
  refused(write("nan.npy", {3, 5}, values), {"nan.npy", "frame 1", "lid_close"});
  write_clip(clips / "cut.npy", model.schema, 8);
  std::filesystem::resize_file(clips / "cut.npy", std::filesystem::file_size(clips / "cut.npy") - 3);
  refused(clips / "cut.npy", {"cut.npy"});
}

TEST_CASE("a clip becomes numbered files, one frame of it a single one") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", clip = folder / "clip.npy";
  const fb::PackedModel model = write_tiny_archive(archive);
  auto controls = write_clip(clip, model.schema, 3);
  const ToolRun run =
      run_tool({"pose", archive, "--clip", clip, "--set", "jaw_open=0.5", "--out", folder / "walk.obj"});
  REQUIRE(run.exit_code == 0);
  CHECK(folder.names() ==
        std::vector<std::string>{"clip.npy", "face.fbk", "walk.0000.obj", "walk.0001.obj", "walk.0002.obj"});
  for (std::size_t f = 0; f < 3; ++f) controls[f * 5] = 0.5f;  // what is set holds in every frame
  const auto positions = evaluate_clip(model, controls);
  const std::size_t size = model.rest.points.size();
  CHECK(read_obj(folder / "walk.0002.obj").points == std::vector<float>(positions.begin() + 2 * size, positions.end()));

  const ToolRun one =
      run_tool({"pose", archive, "--clip", clip, "--set", "jaw_open=0.5", "--frame", "2", "--out", folder / "one.obj"});
  REQUIRE(one.exit_code == 0);
  CHECK(text_of(folder / "one.obj") == text_of(folder / "walk.0002.obj"));
  const ToolRun beyond = run_tool({"pose", archive, "--clip", clip, "--frame", "3", "--out", folder / "two.obj"});
  CHECK(beyond.exit_code == 1);
  CHECK(is_error_line(beyond.err, "pose", {"--frame 3", "0 to 2"}));
}

TEST_CASE("a picture has the given size and does not depend on threads") {
  const ScratchFolder folder;
  const std::string archive = folder / "face.fbk", one = folder / "one.png", two = folder / "two.png";
  write_tiny_archive(archive);
  REQUIRE(run_tool({"pose", archive, "--out", one, "--size", "96x64", "--threads", "1"}).exit_code == 0);
  REQUIRE(run_tool({"pose", archive, "--out", two, "--size", "96x64", "--threads", "3"}).exit_code == 0);
  const std::string png = text_of(one);
  CHECK(png == text_of(two));
  REQUIRE(png.size() > 24);
  CHECK(png.substr(1, 3) == "PNG");
  CHECK(static_cast<unsigned char>(png[19]) == 96);
  CHECK(static_cast<unsigned char>(png[23]) == 64);
}

TEST_CASE("a picture shows the colours of materials") {
  const ScratchFolder folder;
  fb::PackedModel model = fb::character_model();
  for (fb::Material& material : model.character.materials) material.base_colour = {0.1f, 0.1f, 0.9f, 1};
  // Of `blue`, pixels in which it stands out.
  const auto blue = [&](const char* name) {
    const std::string archive = folder / (std::string(name) + ".fbk"), out = folder / (std::string(name) + ".png");
    fb::write_file(archive, fb::archive::write_archive(model, {}));
    REQUIRE(run_tool({"pose", archive, "--out", out, "--size", "96x96"}).exit_code == 0);
    const fb::test::Picture picture = fb::test::read_picture(fb::read_file(out));
    std::size_t count = 0;
    for (std::size_t p = 0; p + 2 < picture.pixels.size(); p += 3)
      count += picture.pixels[p + 2] > 60 + picture.pixels[p];
    return count;
  };
  CHECK(blue("materials") > 300);
  for (fb::Material& material : model.character.materials) material = {};  // nothing but glTF's white
  CHECK(blue("clay") == 0);
}

}  // namespace test_tool_pose
