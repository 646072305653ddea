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
#include "pseudo_terminal.h"
#include "tool_files.h"
#include "tool_run.h"

using fb::Phase;

namespace test_tool_text {

namespace {

// Stages of `facebaker bake sample --recipe compact --use variant --poses 8000 --report report` on two busy cores,
// those of a second or more.
struct RecordedStage {
  Phase phase;
  const char* name;
  double seconds;
};
constexpr RecordedStage recorded_stages[] = {{Phase::sampling, "looking for jumps", 1},
                                             {Phase::sampling, "sampling poses", 5},
                                             {Phase::analysis, "evaluating dense poses", 2},
                                             {Phase::analysis, "ranking correctives", 3},
                                             {Phase::analysis, "fitting correctives", 3},
                                             {Phase::analysis, "looking for jumps in company", 2},
                                             {Phase::analysis, "ranking correctives", 2},
                                             {Phase::analysis, "fitting correctives", 5},
                                             {Phase::analysis, "ranking correctives by subsets", 1},
                                             {Phase::analysis, "fitting correctives", 2},
                                             {Phase::training, "finding local blendshapes", 2},
                                             {Phase::training, "measuring local blendshapes", 2},
                                             {Phase::training, "projecting poses", 2},
                                             {Phase::training, "training narrow networks", 3},
                                             {Phase::training, "evaluating poses of single regions", 22},
                                             {Phase::training, "training", 25},
                                             {Phase::packing, "rounding", 2},
                                             {Phase::packing, "packing", 4},
                                             {Phase::measuring, "measuring controls", 2},
                                             {Phase::measuring, "measuring locality", 1},
                                             {Phase::writing, "drawing worst frames", 2},
                                             {Phase::writing, "drawing posed faces", 2}};

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
  fb::tool::BakePhases phases(false);
  CHECK(phases.name().empty());
  CHECK(phases.begin(Phase::sampling, ""));
  CHECK(phases.name() == "sampling poses");
  CHECK(phases.done() == 0);
  CHECK(!phases.begin(Phase::sampling, ""));
  phases.update(0.5);
  const double sampled = phases.done();
  CHECK(sampled > 0);
  CHECK(phases.begin(Phase::analysis, ""));
  CHECK(phases.name() == "analysing the rig");
  CHECK(!phases.begin(Phase::sampling, ""));  // part of what goes on
  CHECK(phases.name() == "analysing the rig");
  double before = phases.done();
  CHECK(before > sampled);
  for (int i = 0; i < 1000; ++i) {
    CHECK(!phases.begin(Phase::analysis, ""));
    phases.update(0.9);
    phases.update(0.1);
    CHECK(phases.done() >= before);
    before = phases.done();
  }
  CHECK(phases.begin(Phase::training, ""));
  CHECK(phases.name() == "training");
  CHECK(phases.done() >= before);
  CHECK(phases.begin(Phase::packing, ""));
  CHECK(phases.begin(Phase::measuring, ""));
  for (int i = 0; i < 1000; ++i) phases.begin(Phase::measuring, "");
  CHECK(phases.done() > 0.9);
  CHECK(phases.done() <= 1);

  fb::tool::BakePhases resumed(false);
  CHECK(resumed.begin(Phase::training, ""));
  CHECK(resumed.done() > 0.1);  // an earlier run did that
}

TEST_CASE("how long a bake still takes is told where it is known") {
  double whole = 0;
  for (const RecordedStage& stage : recorded_stages) whole += stage.seconds;
  fb::tool::BakePhases phases(true);
  double gone = 0, told_from = whole;
  for (const RecordedStage& stage : recorded_stages) {
    CAPTURE(std::string(stage.name));
    phases.begin(stage.phase, stage.name);
    for (const double part : {0.1, 0.5, 0.9}) {
      phases.update(part);
      const double now = gone + part * stage.seconds;
      const auto left = phases.seconds_left((1 - part) * stage.seconds, now);
      if (!left) continue;
      told_from = std::min(told_from, now);
      CHECK(std::abs(*left - (whole - now)) < 0.05 * whole);
      CHECK(phases.done() < now / whole + 0.1);
    }
    gone += stage.seconds;
  }
  CHECK(told_from < 0.8 * whole);
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
      bar.begin(Phase::sampling, stage, 4);
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
