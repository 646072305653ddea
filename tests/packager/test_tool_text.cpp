// What the tool says while it works, and how it breaks lines.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <sstream>
#include <thread>

#include "commands/bake_phases.h"
#include "commands/progress_bar.h"
#include "commands/terminal.h"
#include "commands/time_left.h"
#include "pseudo_terminal.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_text {

namespace {

// Stages of `facebaker bake sample --recipe compact --poses 600 --epochs 20` on two busy cores, those of a second or
// more.
struct RecordedStage {
  const char* name;
  double seconds;
};
constexpr RecordedStage recorded_stages[] = {{"evaluating single controls", 6},
                                             {"looking for jumps", 1},
                                             {"sampling poses", 4},
                                             {"evaluating controls 1 to 24 of 500", 2},
                                             {"evaluating controls 25 to 48 of 500", 2},
                                             {"evaluating controls 49 to 72 of 500", 1},
                                             {"evaluating controls 73 to 96 of 500", 1},
                                             {"evaluating controls 97 to 120 of 500", 1},
                                             {"evaluating controls 121 to 144 of 500", 1},
                                             {"evaluating controls 145 to 168 of 500", 1},
                                             {"evaluating controls 193 to 216 of 500", 1},
                                             {"evaluating controls 217 to 240 of 500", 1},
                                             {"evaluating controls 241 to 264 of 500", 1},
                                             {"evaluating controls 265 to 288 of 500", 1},
                                             {"evaluating controls 289 to 312 of 500", 1},
                                             {"evaluating controls 313 to 336 of 500", 1},
                                             {"evaluating controls 337 to 360 of 500", 1},
                                             {"evaluating controls 361 to 384 of 500", 1},
                                             {"evaluating controls 385 to 408 of 500", 1},
                                             {"evaluating controls 409 to 432 of 500", 1},
                                             {"evaluating controls 433 to 456 of 500", 1},
                                             {"evaluating controls 457 to 480 of 500", 1},
                                             {"evaluating controls 481 to 500 of 500", 2},
                                             {"evaluating dense poses", 20},
                                             {"validating activation curves", 6},
                                             {"measuring activation curves", 12},
                                             {"ranking correctives", 70},
                                             {"fitting correctives", 109},
                                             {"looking for jumps in company", 38},
                                             {"ranking correctives", 26},
                                             {"ranking correctives by subsets", 8},
                                             {"fitting correctives", 78},
                                             {"ranking correctives", 9},
                                             {"ranking correctives by subsets", 8},
                                             {"fitting correctives", 22},
                                             {"looking for missed correctives", 5},
                                             {"reducing poses with missed correctives", 18},
                                             {"fitting correctives", 3},
                                             {"looking for missed correctives", 6},
                                             {"reducing poses with missed correctives", 20},
                                             {"looking for missed correctives", 5},
                                             {"reducing poses with missed correctives", 19},
                                             {"fitting correctives", 149},
                                             {"looking for local blendshapes", 3},
                                             {"finding local blendshapes", 8},
                                             {"measuring local blendshapes", 6},
                                             {"projecting poses", 5},
                                             {"training narrow networks", 5},
                                             {"training", 9},
                                             {"rounding", 7},
                                             {"packing", 30},
                                             {"measuring", 19},
                                             {"measuring controls", 56}};

}  // namespace

TEST_CASE("lines are broken at spaces, and words stay whole") {
  using fb::tool::wrapped;
  CHECK(wrapped("one two three", 0, 8) == "one two\nthree");
  CHECK(wrapped("one two three", 2, 9) == "one two\n  three");
  CHECK(wrapped("incomprehensibilities", 0, 8) == "incomprehensibilities");
  CHECK(wrapped("a\n  b", 0, 80) == "a\n  b");
  CHECK(wrapped("one two", 0, 0) == "one two");
  CHECK(wrapped("größe größe", 0, 11) == "größe größe");  // counts characters, not bytes
  CHECK(fb::tool::cut_to_width("größe", 3) == "grö");
  CHECK(fb::tool::cut_to_width("ab", 3) == "ab");
}

TEST_CASE("a bake's stages are joined to phases whose share grows from 0 to 1") {
  fb::tool::BakePhases phases;
  CHECK(phases.name().empty());
  CHECK(phases.begin("timing the rig"));
  CHECK(phases.name() == "sampling poses");
  CHECK(phases.done() == 0);
  CHECK(!phases.begin("sampling poses"));
  phases.update(0.5);
  const double sampled = phases.done();
  CHECK(sampled > 0);
  CHECK(phases.begin("evaluating controls 1 to 24 of 500"));
  CHECK(phases.name() == "analysing the rig");
  CHECK(!phases.begin("sampling poses"));  // part of what goes on
  CHECK(phases.name() == "analysing the rig");
  double before = phases.done();
  CHECK(before > sampled);
  for (int i = 0; i < 1000; ++i) {
    CHECK(!phases.begin("fitting correctives"));
    phases.update(0.9);
    phases.update(0.1);
    CHECK(phases.done() >= before);
    before = phases.done();
  }
  CHECK(phases.begin("looking for local blendshapes"));
  CHECK(phases.name() == "training");
  CHECK(phases.done() >= before);
  CHECK(!phases.begin("a stage of a recipe to come"));
  CHECK(phases.begin("rounding"));
  CHECK(phases.begin("measuring"));
  for (int i = 0; i < 1000; ++i) phases.begin("measuring controls");
  CHECK(phases.done() > 0.9);
  CHECK(phases.done() <= 1);

  fb::tool::BakePhases recorded;
  CHECK(recorded.begin("fitting recorded poses"));
  CHECK(!recorded.begin("measuring residuals of recorded poses"));
  CHECK(recorded.name() == "analysing the rig");
  CHECK(recorded.done() < 0.6);
  CHECK(recorded.begin("projecting"));
  CHECK(recorded.name() == "training");

  fb::tool::BakePhases resumed;
  CHECK(resumed.begin("training"));
  CHECK(resumed.done() > 0.1);  // an earlier run did that
}

TEST_CASE("how long a bake still takes is told where it is known") {
  double whole = 0;
  for (const RecordedStage& stage : recorded_stages) whole += stage.seconds;
  fb::tool::BakePhases phases;
  double gone = 0, told_from = whole;
  for (const RecordedStage& stage : recorded_stages) {
    CAPTURE(std::string(stage.name));
    phases.begin(stage.name);
    for (const double part : {0.1, 0.5, 0.9}) {
      phases.update(part);
      const double now = gone + part * stage.seconds;
      const auto left = fb::tool::seconds_left(phases.name(), stage.name, (1 - part) * stage.seconds, now);
      if (!left) continue;
      told_from = std::min(told_from, now);
      CHECK(std::abs(*left - (whole - now)) < 0.1 * whole);
    }
    gone += stage.seconds;
  }
  CHECK(told_from < 0.9 * whole);
}

TEST_CASE("a bake tells each phase once, and how long it took in all") {
  const ScratchFolder folder;
  const ToolRun run =
      run_tool({"bake", FB_TOY_RIG, "--out", folder / "face.fbk", "--recipe", "linear", "--poses", "60"});
  REQUIRE(run.exit_code == 0);
  std::map<std::string, int> told;
  std::istringstream lines(run.err);
  std::string last;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("note: ") || line.starts_with(" ")) continue;
    last = line.substr(0, line.find(':'));
    ++told[last];
  }
  CAPTURE(run.err);
  CHECK(told["sampling poses"] == 1);
  CHECK(told["measuring"] == 1);
  CHECK(last == "in all");
  for (const auto& one : told) CHECK_MESSAGE(one.second == 1, one.first);
}

TEST_CASE("a bar is as wide as there is room for") {
  const std::string stage = "evaluating single controls";
  for (const int columns : {20, 64, 120}) {
    CAPTURE(columns);
    const std::string screen = plain_text(on_terminal(columns, [&] {
      fb::tool::ProgressBar bar;
      bar.begin(stage, 4);
      bar.update(1);
      std::this_thread::sleep_for(std::chrono::milliseconds(150));
      bar.update(2);
    }));
    std::size_t longest = 0;
    std::istringstream lines(screen);
    for (std::string line; std::getline(lines, line);) longest = std::max(longest, line.size());
    CHECK(longest < std::size_t(columns) + (columns == 20 ? stage.size() : 0));  // the last line is not drawn again
    CHECK(screen.find(" 50 %") != std::string::npos);
    CHECK((screen.find("[#") != std::string::npos) == (columns > 20));
  }
}

}  // namespace test_tool_text
