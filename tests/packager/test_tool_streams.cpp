// Standard streams that are full or closed, what the tool prints of names from anyone, and its children when it is
// killed.
#include <doctest/doctest.h>
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include "archive/writer.h"
#include "base/file.h"
#include "test_models.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_streams {

namespace fs = std::filesystem;

namespace {

std::string write_text(const ScratchFolder& folder, const char* name, const std::string& text) {
  fb::write_file(folder / name, text);
  return folder / name;
}

ToolRun run_shell(const std::string& line) {
  return run_program("/bin/sh", {"-c", line});
}

// Whether the text has a byte that commands a terminal.
bool commands_terminal(const std::string& text) {
  return std::ranges::any_of(text,
                             [](char c) { return (static_cast<unsigned char>(c) < ' ' && c != '\n') || c == 127; });
}

// Whether a process is there and runs; one that ended and is not waited for is a zombie.
bool runs(long process) {
  std::ifstream stat("/proc/" + std::to_string(process) + "/stat");
  std::string text;
  if (!std::getline(stat, text)) return false;
  return text.compare(text.rfind(')') + 2, 1, "Z") != 0;
}

bool ends_within_seconds(long process, int seconds) {
  for (int i = 0; i < 20 * seconds && runs(process); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  return !runs(process);
}

// Of the two processes whose numbers are in the file.
void check_that_both_end(const std::string& file) {
  long processes[2] = {0, 0};
  std::ifstream(file) >> processes[0] >> processes[1];
  for (const long process : processes) {
    REQUIRE(process > 1);
    CHECK(ends_within_seconds(process, 10));
    if (runs(process)) ::kill(static_cast<pid_t>(process), SIGKILL);
  }
}

}  // namespace

TEST_CASE("text that standard output does not take is an error") {
  if (!fs::is_character_file("/dev/full")) return;
  for (const std::vector<std::string>& words : {std::vector<std::string>{"--version"},
                                                {"--help"},
                                                {"help", "bake"},
                                                {"help", "--man"},
                                                {"completion", "bash"}}) {
    CAPTURE(words[0]);
    const ToolRun run = run_tool(words, {.standard_output = "/dev/full"});
    CAPTURE(run.err);
    CHECK(run.exit_code == 1);
    CHECK(run.err.find("standard output: writing failed") != std::string::npos);
    CHECK(std::ranges::count(run.err, '\n') == 1);
  }
}

TEST_CASE("closed standard streams are in nobody's way") {
  const ScratchFolder folder;
  const std::string child = std::string("'exec:") + FB_TOOL + " rig-host " + FB_TOY_RIG + "'";
  const std::string bake = std::string(FB_TOOL) + " bake " + child + " --recipe linear --poses 60 --out ";
  const ToolRun open = run_shell(bake + (folder / "open.fbk"));
  REQUIRE_MESSAGE(open.exit_code == 0, open.err);
  for (const char* closed : {"2>&-", "<&- 2>&-", "<&-"}) {
    CAPTURE(closed);
    const std::string out = folder / "closed.fbk";
    CHECK(run_shell(bake + out + " " + closed).exit_code == 0);
    REQUIRE(fs::exists(out));
    CHECK(fb::read_file(out).size() == fb::read_file(folder / "open.fbk").size());
    CHECK(run_tool({"verify", out}).exit_code == 0);
    fs::remove(out);
  }
}

TEST_CASE("names from anyone command no terminal") {
  const ScratchFolder folder;
  const std::string title = "\033]0;title\007", bright =
                                                    "\033[1m\302\233"
                                                    "31m";
  fb::PackedModel model = fb::tiny_packed_model();
  model.schema.name = title + "face";
  model.schema.units = bright + "cm";
  model.schema.controls[0].name = title + "jaw";
  model.schema.controls[1].group = bright + "mouth";
  const std::string face = folder / "face.fbk", other = folder / "other.fbk";
  fb::write_file(face, fb::archive::write_archive(model, {}));
  model.schema.controls[0].name = bright + "jaw";
  fb::write_file(other, fb::archive::write_archive(model, {}));
  const std::string out = folder / "out.obj";
  for (const std::vector<std::string>& words : {std::vector<std::string>{"inspect", face},
                                                {"inspect", face, "--controls"},
                                                {"inspect", face, "--json"},
                                                {"verify", face},
                                                {"pack", face, "--out", folder / "packed.fbk"},
                                                {"diff", face, other},
                                                {"pose", face, "--out", out, "--set", title + "ja=1"},
                                                {"pose", face, "--out", out, "--set", bright + "=1"},
                                                {"pose", face, "--out", out, "--set", title + "jaw=" + bright},
                                                {"export", face, folder / "out.usda", "--set", bright + "jaw=1"},
                                                {"pose", folder / (title + ".fbk"), "--out", out},
                                                {title, face}}) {
    const ToolRun run = run_tool(words);
    CAPTURE(run.out);
    CAPTURE(run.err);
    CHECK(run.out.size() + run.err.size() > 0);
    CHECK_FALSE(commands_terminal(run.out + run.err));
    CHECK((run.out + run.err).find("\302\233") == std::string::npos);
  }
}

TEST_CASE("a farm that is killed leaves no bake behind") {
  const ScratchFolder folder;
  const std::string started = folder / "started";
  const std::string rig = write_text(
      folder, "rig.sh", "echo $PPID $$ >" + started + ".new\nmv " + started + ".new " + started + "\nsleep 1000\n");
  const std::string list = write_text(folder, "list.txt", "slow='exec:/bin/sh " + rig + "' --recipe linear\n");
  const ToolRun run =
      run_tool({"farm", list, "--out", folder / "faces"}, {.interrupt_when_exists = started, .signal = SIGKILL});
  CHECK(run.exit_code == 128 + SIGKILL);
  check_that_both_end(started);
}

TEST_CASE("a tool that is killed leaves no child of a rig behind") {
  const ScratchFolder folder;
  const std::string started = folder / "started";
  // Has a child of its own, and never answers the request that it waits for.
  const std::string rig = write_text(folder, "rig.sh",
                                     "sleep 1000 &\ndd bs=1 count=1 <&3 >/dev/null 2>&1\necho $! $$ >" + started +
                                         ".new\nmv " + started + ".new " + started + "\nwait\n");
  for (const int signal : {SIGKILL, SIGTERM}) {
    CAPTURE(signal);
    fs::remove(started);
    const ToolRun run = run_tool({"bake", "exec:/bin/sh " + rig, "--out", folder / "face.fbk"},
                                 {.interrupt_when_exists = started, .signal = signal});
    CHECK(run.exit_code != 0);
    check_that_both_end(started);
  }
}

}  // namespace test_tool_streams
