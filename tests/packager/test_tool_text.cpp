// What the tool says while it works, and how it breaks lines.
#include <doctest/doctest.h>

#include <chrono>
#include <map>
#include <sstream>
#include <thread>

#include "commands/bake_phases.h"
#include "commands/progress_bar.h"
#include "commands/terminal.h"
#include "pseudo_terminal.h"
#include "tool_files.h"
#include "tool_run.h"

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
  CHECK(phases.begun_at() == 0);
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
  CHECK(resumed.begun_at() > 0.1);
  CHECK(resumed.done() >= resumed.begun_at());
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
