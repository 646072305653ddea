// Plans that follow control curves from outside.
#include <algorithm>
#include <cmath>
#include <set>

#include "bake/dataset/npy.h"
#include "bake/sampling/pose_generators.h"
#include "bake/sampling/pose_plan.h"
#include "bake/sampling/read_examples.h"
#include "bake_test_support.h"
#include "memory_source.h"
#include "watched_progress.h"

namespace test_examples {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

constexpr std::size_t width = 6;  // controls of the toy rig

struct Told final : QuietProgress {
  void note(std::string_view sentence) override { all += std::string(sentence) + "\n"; }
  std::string all;
};

using Pose = std::vector<float>;

std::vector<Pose> poses_of(std::span<const float> controls) {
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < controls.size(); i += width)
    poses.emplace_back(controls.begin() + static_cast<std::ptrdiff_t>(i),
                       controls.begin() + static_cast<std::ptrdiff_t>(i + width));
  return poses;
}

std::string write_text(const Folder& folder, const char* name, const std::string& text) {
  write_file(folder / name, text);
  return (folder / name).string();
}

// In which the jaw opens and the lips press, and nothing else happens.
std::vector<float> mouth_frames() {
  std::vector<float> frames;
  for (int f = 0; f < 40; ++f) {
    const float t = static_cast<float>(f) / 39;
    frames.insert(frames.end(), {0, 0, 0.5f, 0.1f + 0.4f * t, 0.3f * std::sin(3 * t), 0});
  }
  return frames;
}

}  // namespace

TEST_CASE("a take's columns are matched to controls by name, and others are told") {
  const Folder folder;
  const auto toy = open_toy();
  Told notes;
  const std::string take = write_text(folder, "take.csv",
                                      "\xef\xbb\xbfTimecode,JawOpen,jaw_forward,\"lip press\",BrowTwist\r\n"
                                      "01:02:03:04.500,0.25,0.5,1.5,-1\r\n\r\n"
                                      "01:02:03:05.500,1e-1,0.5,0,0\r\n");
  const std::vector<Pose> poses = poses_of(read_examples({take}, *toy, notes));
  REQUIRE(poses.size() == 2);
  CHECK(poses[0] == Pose{0, -1, 0.5f, 0.25f, 1, 0});  // browLift rests at 0.5; 1.5 is clamped
  CHECK(poses[1] == Pose{0, 0, 0.5f, 0.1f, 0, 0});
  for (const char* part : {"no controls are called \"Timecode\", \"jaw_forward\"", "3 of 6 controls have no column",
                           "1 values outside their range were clamped"})
    CHECK_MESSAGE(notes.all.find(part) != std::string::npos, notes.all);
}

TEST_CASE("columns are matched to what controls mean, too, and to their own names first") {
  const Folder folder;
  MemorySource rig(
      4, 3, [](const float*, std::span<float>) {}, true);
  rig.edit_schema().controls[1].labels.arkit = "jawOpen";
  rig.edit_schema().controls[2].labels.facs = "AU12";
  rig.edit_schema().controls[3].labels.arkit = "control0";
  const std::string take = write_text(folder, "take.csv", "JawOpen,au12,Control0\n0.5,0.25,0.75\n");
  CHECK(read_examples({take}, rig, silent_progress()) == Pose{0.75f, 0.5f, 0.25f, 0});
}

TEST_CASE("files that are no control curves of a rig are refused by file, line and column") {
  const Folder folder;
  const auto toy = open_toy();
  const auto refused = [&](const std::string& text, const std::string& part) {
    const std::string file = write_text(folder, "take.csv", text);
    const std::string message = failure(Status::bad_data, [&] { read_examples({file}, *toy, silent_progress()); });
    CHECK_MESSAGE(message.find(part) != std::string::npos, message);
    CHECK(message.find("take.csv") != std::string::npos);
  };
  refused("Timecode,smile\n0,1\n", "no column has the name of a control");
  refused("jawOpen,JawOpen\n0,1\n", "two columns are the control \"jawOpen\"");
  refused("jawOpen,lipPress\n0,1\n1\n", "line 3: 1 cells where the first line names 2");
  refused("jawOpen,lipPress\n0,wide\n", "line 2, column \"lipPress\": \"wide\" is no number");
  write_npy(folder / "frames.npy", {2, 5}, std::vector<float>(10));
  CHECK_THROWS_AS(read_examples({(folder / "frames.npy").string()}, *toy, silent_progress()), Error);
  failure(Status::not_finite,
          [&] { read_examples({write_text(folder, "take.csv", "jawOpen\nnan\n")}, *toy, silent_progress()); });
}

TEST_CASE("a third of a plan is near the examples: frames far from each other, and variations of them") {
  const auto toy = open_toy();
  const std::vector<float> examples = mouth_frames();
  const std::vector<Pose> given = poses_of(examples);
  for (const std::uint64_t budget : {0, 300}) {
    SamplingOptions options;
    options.poses = 300;
    options.rig_budget = budget;
    const PosePlan without = make_plan(*toy, options, {}, silent_progress());
    options.examples = examples;
    const PosePlan plan = make_plan(*toy, options, {}, silent_progress());
    const auto like = std::ranges::find(plan, examples_clip, &Clip::name);
    REQUIRE(like != plan.end());
    CHECK(std::ranges::find(without, examples_clip, &Clip::name) == without.end());
    CHECK(like->split == Split::train);
    CHECK(like->frames > 80);
    CHECK(like->frames < 110);
    std::set<Pose> frames;
    std::size_t near = 0;
    for (const Pose& pose : poses_of(like->controls)) {
      if (std::ranges::find(given, pose) != given.end()) frames.insert(pose);
      near += pose[0] < 0.35f && std::abs(pose[1]) < 0.35f && pose[3] > 0 && pose[5] < 0.35f;
    }
    CHECK(frames.size() > 20);  // a third, none of them twice
    CHECK(near > like->frames * 9 / 10);
  }
  // The frame that is chosen first is the farthest from rest, the next is far from both.
  const RigSchema& schema = toy->schema();
  RigEvaluator rig(*toy);
  const ControlResponses responses(rig, 0, silent_progress());
  const std::vector<Pose> two = poses_of(make_like(schema, responses, examples, 1, 2, 2));
  CHECK(two[0] == given.back());
  CHECK(two[0][3] - two[1][3] > 0.1f);
}

TEST_CASE("no frame of the rig's own test clips is planned, whoever gives it") {
  const Folder folder;
  const auto toy = open_toy();
  const auto test = std::ranges::find(toy->clips(), Split::test, &Clip::split);
  REQUIRE(test != toy->clips().end());
  std::vector<float> frames = mouth_frames();
  frames.insert(frames.end(), test->controls.begin(), test->controls.end());
  write_npy(folder / "both.npy", {frames.size() / width, width}, frames);
  write_npy(folder / "test.npy", {test->frames, width}, test->controls);
  Told notes;
  SamplingOptions options;
  options.poses = 400;
  options.examples = read_examples({(folder / "both.npy").string()}, *toy, notes);
  CHECK(options.examples == mouth_frames());
  CHECK(notes.all.find("12 of 52 frames") != std::string::npos);
  const std::vector<Pose> tested = poses_of(test->controls);
  for (const Clip& clip : make_plan(*toy, options, {}, silent_progress()))
    if (clip.split == Split::train && clip.kind != ClipKind::shot)
      for (const Pose& pose : poses_of(clip.controls)) CHECK(std::ranges::find(tested, pose) == tested.end());
  failure(Status::invalid_argument, [&] { read_examples({(folder / "test.npy").string()}, *toy, silent_progress()); });
  // Of a dataset, clips that are marked test are not read at all.
  SamplingOptions recording;
  recording.poses = 20;
  sample(*toy, recording, folder / "recorded", {}, silent_progress());
  const std::vector<Pose> read = poses_of(read_examples({(folder / "recorded").string()}, *toy, notes));
  CHECK(read.size() == 20 + 4);  // of the training shot, 8 of 12 frames are in the test shot too
}

}  // namespace test_examples
