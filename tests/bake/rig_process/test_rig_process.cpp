// Rigs in child processes: the same points, and every way in which a child can end, hang or lie.
#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "bake/rig/rig_evaluator.h"
#include "bake/rig_process/process_source.h"
#include "bake_test_support.h"
#include "base/random.h"
#include "watched_progress.h"

namespace test_rig_process {

using namespace fb;
using namespace fb::bake;
using namespace fb::test;

namespace {

// FB_RIG_CHILD with a fault.
OpenedSource open_child(const char* fault, const RigRunning& running = {}) {
  return open_source(std::string("exec:exec " FB_RIG_CHILD " '") + fault + "'", running);
}

std::vector<float> random_poses(const RigSchema& schema, std::size_t count) {
  Random random(7);
  std::vector<float> poses;
  for (std::size_t i = 0; i < count; ++i)
    for (const Control& control : schema.controls) poses.push_back(random.uniform(control.minimum, control.maximum));
  return poses;
}

std::vector<float> evaluated(Source& rig, const std::vector<float>& poses) {
  const std::size_t count = poses.size() / rig.schema().control_count();
  std::vector<float> points(count * rig.rest().points.size());
  RigEvaluator(rig).evaluate(poses, count, points);
  return points;
}

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Is cancelled so many seconds after it was made.
struct StopAfter final : QuietProgress {
  explicit StopAfter(double seconds) : at(std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds)) {}
  bool cancelled() const override { return std::chrono::steady_clock::now() >= at; }
  std::chrono::time_point<std::chrono::steady_clock, std::chrono::duration<double>> at;
};

// Children of this process that have not been waited for.
bool has_children() {
  return ::waitpid(-1, nullptr, WNOHANG) >= 0;
}

}  // namespace

TEST_CASE("a rig in children is the same rig, whatever their number") {
  const OpenedSource toy = open_toy();
  const std::vector<float> poses = random_poses(toy->schema(), 301), expected = evaluated(*toy, poses);
  for (const std::size_t workers : {1u, 3u}) {
    const OpenedSource child = open_child("", {.workers = workers});
    CHECK(child->live());
    check_same_controls(child->schema(), "child", toy->schema(), "toy");
    CHECK(child->schema().name == toy->schema().name);
    CHECK(child->rest().points == toy->rest().points);
    CHECK(child->rest().polygon_corners == toy->rest().polygon_corners);
    REQUIRE(child->clips().size() == 2);
    CHECK(child->clips()[1].controls == toy->clips()[1].controls);
    CHECK(child->clips()[1].split == toy->clips()[1].split);
    CHECK(evaluated(*child, poses) == expected);
    std::vector<float> frames(5 * toy->rest().points.size()), again = frames;
    toy->read(1, 3, 5, frames);
    child->read(1, 3, 5, again);
    CHECK(again == frames);
  }
  CHECK_FALSE(has_children());
}

TEST_CASE("what a child prints does not get into its answers, and it may prefer blocks and have a version") {
  const OpenedSource toy = open_toy();
  const std::vector<float> poses = random_poses(toy->schema(), 40);
  for (const char* fault : {"prints", "prefers 7", "version"}) {
    const OpenedSource child = open_child(fault, {.workers = 2});
    CHECK(evaluated(*child, poses) == evaluated(*toy, poses));
    CHECK(child->preferred_block() == (std::string(fault) == "prefers 7" ? 14 : 2));
    CHECK(child->version() == (std::string(fault) == "version" ? "12b" : ""));
  }
}

TEST_CASE("a command is known by its text, a plugin in children by its bytes as in this process") {
  const OpenedSource child = open_child(""), same = open_child("", {.workers = 2}), other = open_child("version");
  CHECK(child->program_hash() != 0);
  CHECK(same->program_hash() == child->program_hash());
  CHECK(other->program_hash() != child->program_hash());
  const OpenedSource hosted = open_source(FB_TOY_RIG, {.workers = 1, .host = FB_RIG_CHILD});
  CHECK(hosted->program_hash() == open_toy().get()->program_hash());
}

TEST_CASE("the pose in which a child crashes, hangs or fails is found, and all others are kept") {
  const struct {
    const char *fault, *message;
  } faults[] = {{"crashes", "was ended by signal 9"},
                {"exits", "ended with exit code 3"},
                {"hangs", "gave no answer for"},
                {"fails", "failed: the twist solver did not converge"},
                {"fails without number", "failed: out of licences"},
                {"nan", "vertex 1 is not finite"}};
  for (const auto& wrong : faults)
    for (const std::size_t workers : {1u, 2u}) {
      CAPTURE(wrong.fault);
      const Folder folder;
      const OpenedSource child = open_child(wrong.fault, {.workers = workers, .pose_seconds = 0.3});
      const std::size_t width = child->schema().control_count(), size = child->rest().points.size(), count = 64;
      std::vector<float> poses = random_poses(child->schema(), count), points(count * size);
      poses[41 * width + 1] = -0.5f;
      // The backend itself flags what it answered.
      std::vector<char> answered(count);
      std::string failed;
      const double seconds = seconds_of([&] {
        try {
          child->make_backend({})->evaluate_block({poses, count, points, answered});
        } catch (const PoseError& error) {
          CHECK(error.pose() == 41);
          failed = error.reason();
        }
      });
      CHECK_MESSAGE(contains(failed, wrong.message), failed);
      CHECK_FALSE(answered[41]);
      CHECK(std::ranges::count(answered, 1) >= 32);
      CHECK(seconds < 8);
      // The children go on after that.
      poses[41 * width + 1] = 0.5f;
      CHECK(evaluated(*child, poses) == evaluated(*open_toy(), poses));
    }
  CHECK_FALSE(has_children());
}

TEST_CASE("a child that does not speak the protocol is refused with what and where") {
  const struct {
    const char* fault;
    std::vector<std::string> words;
  } faults[] = {{"says nothing", {"gave no answer for", "before it said hello"}},
                {"ends at once", {"ended with exit code 0", "before it said hello"}},
                {"is cut off", {"ended with exit code 0", "before it said hello"}},
                {"writes text", {"at byte 0: \"Hello! I am a ri\"", "FBR1"}},
                {"claims much data", {"at byte 0", "bytes of data, more than 4294967296"}},
                {"claims much text", {"at byte 0", "bytes of text, more than"}},
                {"claims vertices", {"the data end within the rest mesh: 12000000000 numbers are needed"}},
                {"claims few vertices", {"the data end within the corners of polygons"}},
                {"is of another version", {"version 2 of the rig protocol, where 1 is spoken"}},
                {"has no name", {"a message: name is missing"}},
                {"is no JSON", {"a message ([\"type\":", "is no JSON: parse error at line 1, column 8"}},
                {"refuses", {"the licence server is asleep"}}};
  for (const auto& wrong : faults) {
    CAPTURE(wrong.fault);
    const auto open = [&] { open_child(wrong.fault, {.pose_seconds = 0.1}); };
    std::string message;
    CHECK(seconds_of([&] { message = failure(Status::rig, open); }) < 3);
    CHECK(message.starts_with("exec:exec "));
    for (const std::string& word : wrong.words) CHECK_MESSAGE(contains(message, word), message);
  }
  const std::string none = failure(Status::rig, [] { open_source("exec:/no/such/program --at all"); });
  CHECK_MESSAGE(contains(none, "ended with exit code 127 before it said hello"), none);
  CHECK_FALSE(has_children());
}

TEST_CASE("a child that is another rig when it is started again is refused") {
  const OpenedSource child = open_child("another");
  const std::size_t size = child->rest().points.size();
  std::vector<float> pose = child->schema().rest_pose(), points(size);
  pose[1] = -0.5f;
  const std::string message = failure(Status::rig, [&] { RigEvaluator(*child).evaluate(pose, 1, points); });
  CHECK_MESSAGE(contains(message, "it says that it is another rig"), message);
}

TEST_CASE("an interruption kills children at work within a second, and what they answered is kept") {
  const Folder folder;
  const OpenedSource toy = open_toy();
  const std::vector<float> poses = random_poses(toy->schema(), 60), expected = evaluated(*toy, poses);
  std::uint64_t asked = 0;
  {
    const OpenedSource child = open_child("slow", {.workers = 3});
    StopAfter progress(0.9);
    RigEvaluator rig(*child, {.progress = &progress}, folder / "evaluations");
    std::vector<float> points(expected.size());
    CHECK(seconds_of([&] { failure(Status::interrupted, [&] { rig.evaluate_cached(poses, 60, points); }); }) < 1.9);
    asked = rig.evaluated();
    CHECK(asked < 60);
  }
  CHECK_FALSE(has_children());
  const OpenedSource child = open_child("slow", {.workers = 3});
  RigEvaluator rig(*child, {}, folder / "evaluations");
  std::vector<float> points(expected.size());
  rig.evaluate_cached(poses, 60, points);
  CHECK(points == expected);
  CHECK(rig.evaluated() <= 60 - asked + 3 * 2);  // what three children were at is lost
}

TEST_CASE("a child that says nothing, or hangs in its rest pose, can be interrupted") {
  for (const char* fault : {"says nothing", "hangs at rest"}) {
    StopAfter progress(0.5);
    CHECK(seconds_of([&] { failure(Status::interrupted, [&] { open_child(fault, {.progress = &progress}); }); }) < 1.5);
  }
  CHECK_FALSE(has_children());
}

TEST_CASE("poses of a slow rig are evaluated by all children at once, in blocks of about a second") {
  const OpenedSource child = open_child("slow", {.workers = 4});
  Questions progress;
  RigEvaluator rig(*child, {.progress = &progress});
  const std::vector<float> poses = random_poses(child->schema(), 64);
  std::vector<float> points(64 * child->rest().points.size());
  CHECK(rig.block_poses() == 4);
  CHECK(seconds_of([&] { rig.evaluate(poses, 64, points); }) < 4.5);  // 6.4 s of work, and starts
  CHECK(rig.block_poses() > 4);                                       // about 40 on an idle machine
}

}  // namespace test_rig_process
