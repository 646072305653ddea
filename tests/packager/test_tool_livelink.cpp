// pose --livelink: recordings of facial capture drive whatever has ARKit names.
#include <doctest/doctest.h>

#include <sstream>

#include "archive/writer.h"
#include "base/file.h"
#include "base/status.h"
#include "glb_reading.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_livelink {

namespace {

// The columns of the app, in its order.
const char* const columns =
    "Timecode,BlendshapeCount,EyeBlinkLeft,EyeLookDownLeft,EyeLookInLeft,EyeLookOutLeft,EyeLookUpLeft,EyeSquintLeft,"
    "EyeWideLeft,EyeBlinkRight,EyeLookDownRight,EyeLookInRight,EyeLookOutRight,EyeLookUpRight,EyeSquintRight,"
    "EyeWideRight,JawForward,JawRight,JawLeft,JawOpen,MouthClose,MouthFunnel,MouthPucker,MouthRight,MouthLeft,"
    "MouthSmileLeft,MouthSmileRight,MouthFrownLeft,MouthFrownRight,MouthDimpleLeft,MouthDimpleRight,MouthStretchLeft,"
    "MouthStretchRight,MouthRollLower,MouthRollUpper,MouthShrugLower,MouthShrugUpper,MouthPressLeft,MouthPressRight,"
    "MouthLowerDownLeft,MouthLowerDownRight,MouthUpperUpLeft,MouthUpperUpRight,BrowDownLeft,BrowDownRight,BrowInnerUp,"
    "BrowOuterUpLeft,BrowOuterUpRight,CheekPuff,CheekSquintLeft,CheekSquintRight,NoseSneerLeft,NoseSneerRight,"
    "TongueOut,HeadYaw,HeadPitch,HeadRoll,LeftEyeYaw,LeftEyePitch,LeftEyeRoll,RightEyeYaw,RightEyePitch,RightEyeRoll";

struct Row {
  std::string timecode;
  float jaw = 0, blink = 0;  // JawOpen, EyeBlinkLeft
  int count = 61;
};

void write_recording(const std::string& path, const std::vector<Row>& rows) {
  std::string text = std::string("\xef\xbb\xbf") + columns + "\r\n";
  for (const Row& row : rows) {
    text += row.timecode + "," + std::to_string(row.count);
    for (int column = 0; column < 61; ++column)
      text += row.count == 0 ? ","
                             : fb::format(",%.9g", double(column == 0    ? row.blink
                                                          : column == 17 ? row.jaw
                                                                         : 0.5f));
    text += "\r\n";
  }
  fb::write_file(path, text);
}

// The tiny model: jaw_open and lid_close, which has a unit and goes to 2, have ARKit names.
fb::PackedModel labelled_model() {
  fb::PackedModel model = fb::tiny_packed_model();
  model.schema.controls[0].labels.arkit = "jawOpen";
  model.schema.controls[3].labels.arkit = "eyeBlinkLeft";
  model.schema.controls[3].labels.unit = "degrees";
  return model;
}

struct Recorded {
  Recorded(const fb::PackedModel& face, const std::vector<Row>& rows) : model(face) {
    fb::write_file(folder / "face.fbk", fb::archive::write_archive(model, {}));
    write_recording(folder / "take.csv", rows);
  }
  ToolRun pose(const std::string& out, std::vector<std::string> options = {}) const {
    options.insert(options.begin(),
                   {"pose", folder / "face.fbk", "--livelink", folder / "take.csv", "--out", folder / out});
    return run_tool(options);
  }
  // Of the frame in an .obj file.
  std::vector<float> points(const std::string& name) const {
    const auto bytes = fb::read_file(folder / name);
    std::istringstream lines(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    std::vector<float> points;
    for (std::string line; std::getline(lines, line);)
      if (line.starts_with("v ")) {
        std::istringstream words(line.substr(2));
        for (float value; words >> value;) points.push_back(value);
      }
    return points;
  }
  std::vector<float> posed(float jaw, float lid) const {
    std::vector<float> controls = model.schema.rest_pose();
    controls[0] = jaw;
    controls[3] = lid;
    return evaluate_clip(model, controls);
  }

  ScratchFolder folder;
  fb::PackedModel model;
};

}  // namespace

TEST_CASE("a recording poses the controls with ARKit names, frame by frame") {
  const Recorded take(
      labelled_model(),
      {{"14:03:59:28.207", 0.25f, 0.5f}, {"14:03:59:29.207", 0.75f, 1}, {"14:04:00:00.207", 1.5f, 0.25f}});
  const ToolRun run = take.pose("a.obj");
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  CHECK(take.folder.names() ==
        std::vector<std::string>{"a.0000.obj", "a.0001.obj", "a.0002.obj", "face.fbk", "take.csv"});
  CHECK(take.points("a.0000.obj") == take.posed(0.25f, 1));  // the lid's unit: half of its range
  CHECK(take.points("a.0001.obj") == take.posed(0.75f, 2));
  CHECK(take.points("a.0002.obj") == take.posed(1, 0.5f));  // clamped
  for (const char* part : {"no controls have the names \"EyeLookDownLeft\"", "\"HeadYaw\"", "\"RightEyeRoll\"",
                           "3 of 5 controls have no column", "1.5 is outside 0 to 1 and is clamped from frame 2"})
    CHECK_MESSAGE(run.err.find(part) != std::string::npos, part);
  CHECK(run.err.find("Timecode") == std::string::npos);
  REQUIRE(take.pose("one.obj", {"--frame", "1", "--set", "jaw_open=0.5"}).exit_code == 0);
  CHECK(take.points("one.obj") == take.posed(0.5f, 2));
  CHECK(take.pose("a.png", {"--size", "32x32"}).exit_code == 0);
}

// A sentence of a second, again and again, on a face of 6,347 vertices and 926 coefficients.
TEST_CASE("a longer take needs little more memory") {
  const ScratchFolder folder;
  REQUIRE(run_tool({"bake", "sample", "--out", folder / "face.fbk", "--recipe", "linear", "--use", "variant", "--poses",
                    "50"})
              .exit_code == 0);
  const auto peak = [&](int frames) {
    std::vector<Row> rows;
    for (int f = 0; f < frames; ++f)
      rows.push_back(
          {fb::format("10:%02d:%02d:%02d", f / 3600, f / 60 % 60, f % 60), float(f % 60) / 60, float(f % 40) / 40});
    write_recording(folder / "take.csv", rows);
    const ToolRun run =
        run_tool({"pose", folder / "face.fbk", "--livelink", folder / "take.csv", "--out", folder / "take.glb"});
    REQUIRE_MESSAGE(run.exit_code == 0, run.err);
    return double(run.peak_bytes);
  };
  constexpr int few = 1000, many = 4000;
  const double a_frame = (peak(many) - peak(few)) / (many - few);
  MESSAGE(a_frame, " bytes a frame");
  CHECK(a_frame < 3300);  // of which 500 controls are 2,000
}

TEST_CASE("controls that are called as ARKit calls them need no labels") {
  fb::PackedModel model = fb::tiny_packed_model();
  model.schema.controls[0].name = "JAW_open";
  model.schema.controls[3].name = "eyeBlink_L";
  const Recorded take(model, {{"00:00:00:00", 0.25f, 0.5f}});
  REQUIRE(take.pose("a.obj").exit_code == 0);
  CHECK(take.points("a.obj") == take.posed(0.25f, 0.5f));
}

TEST_CASE("the timecodes of a recording tell its rate, and rows that are missing are interpolated") {
  // 30 frames of timecode a second, two rows each; two are missing, two more have no face.
  const Recorded take(labelled_model(), {{"23:59:59:28.5", 0, 0},
                                         {"23:59:59:29", 0.25f, 0},
                                         {"23:59:59:29", 0.9f, 0},
                                         {"23:59:59:29.5", 0.5f, 0},
                                         {"00:00:00:00", 9, 9, 0},
                                         {"00:00:00:01", 0.5f, 0.75f},
                                         {"00:00:00:01.5", 0.75f, 0.75f}});
  const ToolRun run = take.pose("a.glb");
  CAPTURE(run.err);
  REQUIRE(run.exit_code == 0);
  CHECK(run.err.find("2 rows without a face or a timecode of their own are left out") != std::string::npos);
  const tinygltf::Model scene = load_glb(take.folder / "a.glb");
  const std::vector<float> times = floats(scene, scene.animations.at(0).samplers.at(0).input);
  REQUIRE(times.size() == 7);
  for (std::size_t f = 0; f < 7; ++f) CHECK(times[f] == doctest::Approx(double(f) / 60));
  REQUIRE(take.pose("a.obj").exit_code == 0);
  CHECK(take.points("a.0001.obj") == take.posed(0.25f, 0));
  const std::vector<float> between = take.points("a.0004.obj"), expected = take.posed(0.5f, 1);
  for (std::size_t i = 0; i < expected.size(); ++i) CHECK(between[i] == doctest::Approx(expected[i]).epsilon(1e-4));
  REQUIRE(take.pose("b.obj", {"--fps", "20"}).exit_code == 0);
  CHECK(take.points("b.0001.obj") == take.points("a.0003.obj"));
  CHECK(take.points("b.0002.obj") == take.points("a.0006.obj"));
}

TEST_CASE("what cannot drive a face is refused by file, line and column") {
  const Recorded take(labelled_model(), {{"00:00:00:00"}});
  const auto refused = [&](const std::string& text, const std::vector<std::string>& words) {
    fb::write_file(take.folder / "take.csv", text);
    const ToolRun run = take.pose("a.obj");
    CAPTURE(run.err);
    CHECK(run.exit_code == 1);
    CHECK(is_error_line(run.err, "pose", words));
    CHECK(take.folder.names() == std::vector<std::string>{"face.fbk", "take.csv"});
  };
  refused("", {"take.csv", "no recording of Live Link Face"});
  refused("JawOpen\n1\n", {"take.csv", "Timecode"});
  refused("Timecode,Smile\n00:00:00:00,1\n", {"take.csv", "\"tiny\"", "jawOpen", "arkit"});
  refused("Timecode,JawOpen\n", {"take.csv", "no frames of a face"});
  refused("Timecode,JawOpen,jaw_open\n00:00:00:00,1,1\n", {"two columns", "\"jaw_open\""});
  refused("Timecode,JawOpen\n00:00:00:00,wide\n", {"line 2", "\"JawOpen\"", "\"wide\""});
  refused("Timecode,JawOpen\n00:00:00:00,nan\n", {"line 2", "\"JawOpen\"", "nan"});
  refused("Timecode,JawOpen\n00:00:00:00,1\n00:00:00:01\n", {"line 3", "1 cells"});
  for (const char* timecode : {"1.5", "00:00:00", "00:00:00:-1", "00:61:00:00", "24:00:00:00", "00:00:00:00x", ""})
    refused("Timecode,JawOpen\n" + std::string(timecode) + ",1\n",
            {"line 2", "the timecode \"" + std::string(timecode)});
  refused("Timecode,JawOpen\n00:00:01:00,1\n00:00:00:05,1\n", {"line 3", "earlier"});
  refused("Timecode,JawOpen\n00:00:00:00,1\n00:00:00:01,1\n11:00:00:01,1\n\n22:00:00:01,1\n20:00:00:00,1",
          {"line 7", "earlier"});
  const ToolRun both = run_tool({"pose", take.folder / "face.fbk", "--livelink", take.folder / "take.csv", "--clip",
                                 "x.npy", "--out", take.folder / "a.obj"});
  CHECK(both.exit_code != 0);
}

TEST_CASE("a recording of endless gaps is refused before it fills the memory") {
  const Recorded take(labelled_model(), {{"00:00:00:00"}, {"00:00:00:01"}, {"11:00:00:01"}, {"22:00:00:01"}});
  const ToolRun run = take.pose("a.obj", {"--fps", "1000"});
  CAPTURE(run.err);
  CHECK(run.exit_code == 1);
  CHECK(is_error_line(run.err, "pose", {"take.csv", "too many"}));
}

}  // namespace test_tool_livelink
