// Rigs in child processes, and rigs that print, as a user of the tool meets them.
#include <doctest/doctest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "tool_files.h"
#include "tool_run.h"

namespace {

ToolSetting with_fault(const char* fault) {
  ToolSetting setting;
  setting.environment = {std::string("FB_FAULT=") + fault};
  return setting;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// Processes whose environment has this text.
std::size_t processes_with(const std::string& marker) {
  std::size_t found = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream file(entry.path() / "environ", std::ios::binary);
    found += contains(std::string(std::istreambuf_iterator<char>(file), {}), marker);
  }
  return found;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

TEST_CASE("what a rig prints goes to standard error, not into results") {
  const ScratchFolder folder;
  for (const char* isolate : {"", "--isolate"}) {
    std::vector<std::string> arguments = {"sample",  FB_HOSTILE_RIG, "--out", folder / (std::string("poses") + isolate),
                                          "--poses", "50",           "--json"};
    if (*isolate) arguments.emplace_back(isolate);
    const ToolRun run = run_tool(arguments, with_fault("prints"));
    CHECK(run.exit_code == 0);
    CHECK(nlohmann::json::accept(run.out));
    CHECK(contains(run.err, "the sheet is opened\n"));
    CHECK(contains(run.err, "the sheet evaluates a pose\n"));
  }
}

TEST_CASE("a face has the same bytes whether its rig runs in this process or in children") {
  const ScratchFolder folder;
  std::vector<std::vector<std::byte>> faces;
  const std::string serve = std::string("exec:'") + FB_TOOL + "' rig-host '" + FB_TOY_RIG + "'";
  const std::vector<std::vector<std::string>> ways = {
      {FB_TOY_RIG}, {FB_TOY_RIG, "--isolate"}, {FB_TOY_RIG, "--workers", "3"}, {serve}, {serve, "--workers", "2"}};
  for (const auto& way : ways) {
    const std::string out = folder / ("face" + std::to_string(faces.size()) + ".fbk");
    std::vector<std::string> arguments = {"bake", "--out", out, "--recipe", "linear", "--poses", "300"};
    arguments.insert(arguments.end(), way.begin(), way.end());
    const ToolRun run = run_tool(arguments);
    CHECK_MESSAGE(run.exit_code == 0, run.err);
    faces.push_back(fb::read_file(out));
    CHECK(faces.back() == faces[0]);
  }
  const ToolRun measured = run_tool({"eval", folder / "face0.fbk", serve});
  CHECK(measured.exit_code == 0);
  CHECK(measured.out == run_tool({"eval", folder / "face0.fbk", FB_TOY_RIG}).out);
}

TEST_CASE("a rig that crashes or hangs in a child is named with its pose, and the tool lives on") {
  const struct {
    const char *fault, *word;
  } faults[] = {{"crashes", "was ended by signal 9"}, {"hangs", "gave no answer for"}};
  for (const auto& wrong : faults) {
    const ScratchFolder folder;
    const auto start = std::chrono::steady_clock::now();
    const ToolRun run = run_tool({"sample", FB_HOSTILE_RIG, "--out", folder / "poses", "--poses", "100", "--workers",
                                  "2", "--rig-timeout", "0.4"},
                                 with_fault(wrong.fault));
    CHECK(run.exit_code == 1);
    CHECK(seconds_since(start) < 10);
    for (const char* part : {"facebaker sample: ", "\"strip2\" at ", wrong.word})
      CHECK_MESSAGE(contains(run.err, part), run.err);
  }
}

TEST_CASE("poses that fail are left out where the user wants it, and are counted") {
  const ScratchFolder folder;
  const std::vector<std::string> sample = {"sample", FB_HOSTILE_RIG, "--out", folder / "poses",       "--poses",
                                           "200",    "--workers",    "2",     "--skip-failing-poses", "--json"};
  const ToolRun run = run_tool(sample, with_fault("throws on a pose"));
  CHECK_MESSAGE(run.exit_code == 0, run.err);
  const auto report = nlohmann::json::parse(run.out);
  const int left_out = report.at("left_out");
  CHECK(left_out > 0);
  CHECK(left_out < 100);
  CHECK(contains(run.err, "note: a pose is left out (clip \"dense\", frame "));
  CHECK(contains(run.err, "the brow is missing"));
  // The same command has nothing left to do, and the dataset trains a face.
  const auto again = nlohmann::json::parse(run_tool(sample, with_fault("throws on a pose")).out);
  CHECK(again.at("left_out") == left_out);
  CHECK(again.at("evaluated") == 0);
  const ToolRun bake = run_tool({"bake", folder / "poses", "--out", folder / "face.fbk", "--recipe", "linear"});
  CHECK_MESSAGE(bake.exit_code == 0, bake.err);
  // Without the option the pose is named.
  const ToolRun refused =
      run_tool({"sample", FB_HOSTILE_RIG, "--out", folder / "none", "--poses", "200"}, with_fault("throws on a pose"));
  CHECK(refused.exit_code == 1);
  CHECK_MESSAGE(contains(refused.err, "\"strip2\" at "), refused.err);
}

TEST_CASE("a rig budget is what was asked for, or refused with what it must be at least") {
  const ScratchFolder folder;
  const auto bake = [&](const char* budget) {
    return run_tool(
        {"bake", FB_TOY_RIG, "--out", folder / "face.fbk", "--recipe", "linear", "--rig-budget", budget, "--json"});
  };
  const ToolRun refused = bake("8");
  CHECK(refused.exit_code == 1);
  CHECK_MESSAGE(is_error_line(refused.err, "bake", {"a rig budget of 8", "needs 9 at least"}), refused.err);
  for (const int budget : {9, 40}) {
    const ToolRun run = bake(std::to_string(budget).c_str());
    CHECK_MESSAGE(run.exit_code == 0, run.err);
    CHECK(nlohmann::json::parse(run.out).at("asked") <= budget);
  }
}

TEST_CASE("Ctrl-C ends a command within a second, with its children, and the same command goes on") {
  const ScratchFolder folder;
  const std::string marker = "FB_MARK=" + folder.path();
  const auto bake = [&](const std::string& out, int signal_after_us) {
    ToolSetting setting = with_fault("is slow");
    setting.environment.push_back(marker);
    setting.signal_after_us = signal_after_us;
    return run_tool(
        {"bake", FB_HOSTILE_RIG, "--out", folder / out, "--recipe", "linear", "--poses", "100", "--workers", "2"},
        setting);
  };
  const auto start = std::chrono::steady_clock::now();
  const ToolRun stopped = bake("face.fbk", 1'000'000);
  CHECK(seconds_since(start) < 2);
  CHECK(stopped.exit_code == 1);
  CHECK_MESSAGE(contains(stopped.err, "interrupted; what is done is kept"), stopped.err);
  CHECK(processes_with(marker) == 0);
  CHECK(std::filesystem::file_size(folder / "face.fbk.work/rig.evaluations") > 10 * 3 * 64 * sizeof(float));
  CHECK(bake("face.fbk", -1).exit_code == 0);
  CHECK(bake("whole.fbk", -1).exit_code == 0);
  CHECK(fb::read_file(folder / "face.fbk") == fb::read_file(folder / "whole.fbk"));
}

TEST_CASE("a source that cannot be served is told once, and rig-host speaks to a parent only") {
  const ToolRun none = run_tool({"bake", "/no/such/rig.so", "--isolate", "--out", "/no/such/face.fbk"});
  CHECK(none.exit_code == 1);
  CHECK_MESSAGE(is_error_line(none.err, "bake", {"/no/such/rig.so: no such file or folder"}), none.err);
  const ToolRun alone = run_program("/bin/sh", {"-c", "exec '" FB_TOOL "' rig-host '" FB_TOY_RIG "' 3<&- 4>&-"});
  CHECK(alone.exit_code == 1);
  CHECK_MESSAGE(is_error_line(alone.err, "rig-host", {"descriptor 3 cannot be read"}), alone.err);
  const ToolRun command = run_tool({"sample", "exec:exit 3", "--out", "/no/such/poses"});
  CHECK(command.exit_code == 1);
  CHECK_MESSAGE(
      is_error_line(command.err, "sample", {"exec:exit 3: its process ended with exit code 3 before it said hello"}),
      command.err);
}
