// Rigs in child processes, and rigs that print, as a user of the tool meets them.
#include <doctest/doctest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "archive/reader.h"
#include "archive/writer.h"
#include "base/file.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_rigs {

namespace {

ToolSetting with_fault(const char* fault) {
  ToolSetting setting;
  setting.environment = {std::string("FB_FAULT=") + fault};
  return setting;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

std::string text_of(const std::string& path) {
  const std::vector<std::byte> bytes = fb::read_file(path);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
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

// Without what it says of its sources: a plugin is a file, a command is none.
std::vector<std::byte> without_provenance(const std::string& path) {
  fb::archive::Archive face = fb::archive::read_archive(fb::read_file(path));
  face.model.provenance.clear();
  return fb::archive::write_archive(face.model, face.proof, face.text);
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
    faces.push_back(without_provenance(out));
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

TEST_CASE("a rig's own clips have a budget apart, which is the rig budget if nothing else is said") {
  const ScratchFolder folder;
  const std::string face = folder / "face.fbk";
  const auto measured_frames = [&] {
    const ToolRun run = run_tool({"inspect", face, "--json"});
    return nlohmann::json::parse(run.out).at("certificate").at("independent").at("frames").get<int>();
  };
  // The rig has 12 frames to test with, and 12 to train on.
  const auto bake = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"bake",   FB_TOY_RIG,     "--out", face,    "--recipe",
                                          "linear", "--rig-budget", "9",     "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ToolRun run = run_tool(arguments);
    CHECK_MESSAGE(run.exit_code == 0, run.err);
    return nlohmann::json::parse(run.out);
  };
  const auto by_default = bake({});
  CHECK(measured_frames() == 9);
  CHECK(by_default.at("asked") <= 9);
  CHECK(by_default.at("poses") == 18);
  CHECK(bake({"--clip-budget", "5"}).at("poses") == 14);
  CHECK(measured_frames() == 5);
  bake({"--clip-budget", "100"});
  CHECK(measured_frames() == 12);
  const ToolRun eval = run_tool({"eval", face, FB_TOY_RIG, "--clip-budget", "4", "--json", "-"});
  CHECK_MESSAGE(eval.exit_code == 0, eval.err);
  CHECK(nlohmann::json::parse(eval.out).at("total").at("frames") == 4);
}

TEST_CASE("a bake tells what it will ask of a rig before it does, and afterwards what it has asked") {
  const ScratchFolder folder;
  const ToolRun run = run_tool({"bake", FB_TOY_RIG, "--out", folder / "face.fbk", "--recipe", "linear", "--rig-budget",
                                "200", "--json", "--report", folder / "report"});
  CHECK_MESSAGE(run.exit_code == 0, run.err);
  const std::size_t told = run.err.find("note: what the rig will be asked, at ");
  REQUIRE(told != std::string::npos);
  CHECK(told < run.err.find("evaluating single controls: "));
  const auto figures = nlohmann::json::parse(run.out);
  CHECK(figures.at("plan").at("pose_seconds") > 0);
  std::map<std::string, std::uint64_t> most, asked, evaluated;
  std::uint64_t all_asked = 0, all_evaluated = 0;
  for (const auto& stage : figures.at("plan").at("stages")) {
    most[stage.at("stage")] = stage.at("most");
    CHECK(contains(run.err, "\n  " + stage.at("stage").get<std::string>() + " "));
  }
  const std::string page = text_of(folder / "report/index.html");
  CHECK(contains(page, "What the rig was asked"));
  for (const auto& stage : figures.at("asked_by_stage")) {
    const std::string name = stage.at("stage");
    all_asked += asked[name] = stage.at("asked");
    all_evaluated += evaluated[name] = stage.at("evaluated");
    CHECK(asked[name] <= most[name]);
    CHECK(contains(page, name));
  }
  CHECK(all_asked == figures.at("asked"));
  CHECK(all_evaluated == figures.at("rig_calls"));
  CHECK(asked.at("single controls") > 0);
  CHECK(asked.at("drawn poses") > 0);
  CHECK(asked.at("clips and test poses") == 0);
  CHECK(evaluated.at("clips and test poses") >= most.at("clips and test poses"));
  // A quick rig without a budget has a sentence.
  const ToolRun quick =
      run_tool({"bake", FB_TOY_RIG, "--out", folder / "quick.fbk", "--recipe", "linear", "--poses", "300"});
  CHECK(contains(quick.err, "note: the rig will be asked about "));
}

TEST_CASE("within a small budget, hero is no worse than linear blendshapes of the same calls") {
  const ScratchFolder folder;
  const auto mse = [&](const char* recipe, const char* budget) {
    const std::string face = folder / "face.fbk";
    const ToolRun bake =
        run_tool({"bake", FB_TOY_RIG, "--out", face, "--recipe", recipe, "--rig-budget", budget, "--epochs", "20"});
    CHECK_MESSAGE(bake.exit_code == 0, bake.err);
    return nlohmann::json::parse(run_tool({"eval", face, FB_TOY_RIG, "--json", "-"}).out)
        .at("total")
        .at("mse")
        .get<double>();
  };
  CHECK(mse("hero", "10") <= 1.01 * mse("linear", "10"));
}

TEST_CASE("a bake leaves failing poses out where the user wants it") {
  const ScratchFolder folder;
  const auto bake = [&](const char* recipe, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"bake",     FB_HOSTILE_RIG, "--out",    folder / "face.fbk",
                                          "--recipe", recipe,         "--epochs", "1",
                                          "--poses",  "300",          "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_tool(arguments, with_fault("throws on a pose"));
  };
  CHECK(bake("linear", {}).exit_code == 1);
  const ToolRun run = bake("hero", {"--skip-failing-poses"});
  CHECK_MESSAGE(run.exit_code == 0, run.err);
  for (const char* part :
       {"note: a pose is left out (clip \"dense\", frame ", "the brow is missing",
        "note: the rig is not analysed, and blendshapes are fitted to the training poses instead: control \"strip",
        "note: the face is not measured control by control: "})
    CHECK_MESSAGE(contains(run.err, part), run.err);
}

TEST_CASE("--poses-like decides what is asked") {
  const ScratchFolder folder;
  fb::write_file(folder / "take.csv", "Timecode,JawOpen,LipPress\n0,0.5,0.5\n1,0.9,0.2\n2,0.1,0.8\n");
  const auto asked = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {
        "bake", FB_TOY_RIG, "--out", folder / "face.fbk", "--recipe", "linear", "--rig-budget", "120", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ToolRun run = run_tool(arguments);
    CHECK_MESSAGE(run.exit_code == 0, run.err);
    std::uint64_t poses = 0;
    const auto figures = nlohmann::json::parse(run.out);
    for (const auto& stage : figures.at("asked_by_stage"))
      if (stage.at("stage") == "poses like the examples") poses = stage.at("asked");
    return poses;
  };
  CHECK(asked({}) == 0);
  CHECK(asked({"--poses-like", folder / "take.csv"}) > 30);
  const ToolRun refused =
      run_tool({"sample", FB_TOY_RIG, "--out", folder / "poses", "--poses-like", folder / "no.csv"});
  CHECK(refused.exit_code == 1);
  CHECK(is_error_line(refused.err, "sample", {"no.csv"}));
}

TEST_CASE("a rig that a face is posed beside or timed on runs in a child where the user wants it") {
  const ScratchFolder folder;
  const std::string face = folder / "face.fbk";
  CHECK(run_tool({"bake", FB_HOSTILE_RIG, "--out", face, "--recipe", "linear", "--poses", "100"}).exit_code == 0);
  const std::vector<std::string> pose = {"pose",     face,           "--set",    "strip2=1",
                                         "--set",    "strip3=1",     "--out",    folder / "x.png",
                                         "--beside", FB_HOSTILE_RIG, "--isolate"};
  const ToolRun crashed = run_tool(pose, with_fault("crashes"));
  CHECK(crashed.exit_code == 1);
  CHECK_MESSAGE(contains(crashed.err, "was ended by signal 9"), crashed.err);
  CHECK(run_tool(pose).exit_code == 0);
  const std::string toy = folder / "toy.fbk";
  CHECK(run_tool({"bake", FB_TOY_RIG, "--out", toy, "--recipe", "linear", "--poses", "100"}).exit_code == 0);
  const ToolRun timed = run_tool({"bench", toy, "--source", FB_TOY_RIG, "--isolate", "--rounds", "1"});
  CHECK_MESSAGE(timed.exit_code == 0, timed.err);
}

TEST_CASE("Ctrl-C ends a command within a second, with its children, and the same command goes on") {
  const ScratchFolder folder;
  const std::string marker = "FB_MARK=" + folder.path();
  const std::string evaluations = folder / "face.fbk.work/rig.evaluations";
  const unsigned long ten_poses = 10 * 3 * 64 * sizeof(float);
  const auto bake = [&](const std::string& out, bool interrupted) {
    ToolSetting setting = with_fault("is slow");
    setting.environment.push_back(marker);
    if (interrupted) setting.interrupt_when_exists = evaluations;
    setting.interrupt_when_bytes = ten_poses;
    return run_tool(
        {"bake", FB_HOSTILE_RIG, "--out", folder / out, "--recipe", "linear", "--poses", "100", "--workers", "2"},
        setting);
  };
  const ToolRun stopped = bake("face.fbk", true);
  CHECK(stopped.seconds_to_end < 1);
  CHECK(stopped.exit_code == 1);
  CHECK_MESSAGE(contains(stopped.err, "interrupted; what is done is kept"), stopped.err);
  CHECK(processes_with(marker) == 0);
  CHECK(std::filesystem::file_size(evaluations) >= ten_poses);
  CHECK(bake("face.fbk", false).exit_code == 0);
  CHECK(bake("whole.fbk", false).exit_code == 0);
  CHECK(fb::read_file(folder / "face.fbk") == fb::read_file(folder / "whole.fbk"));
}

TEST_CASE("a source that cannot be served is told once, and rig-host speaks to a parent only") {
  const ToolRun none = run_tool({"bake", "/no/such/rig.so", "--isolate", "--out", "/no/such/face.fbk"});
  CHECK(none.exit_code == 1);
  CHECK_MESSAGE(is_error_line(none.err, "bake", {"/no/such/rig.so: no such file or folder"}), none.err);
  CHECK_MESSAGE(!contains(none.err, "sample"), none.err);
  const ToolRun mistyped = run_tool({"bake", "smaple", "--out", "/no/such/face.fbk"});
  CHECK(mistyped.exit_code == 1);
  CHECK_MESSAGE(is_error_line(mistyped.err, "bake", {"smaple: no such file or folder", "named \"sample\""}),
                mistyped.err);
  const ToolRun alone = run_program("/bin/sh", {"-c", "exec '" FB_TOOL "' rig-host '" FB_TOY_RIG "' 3<&- 4>&-"});
  CHECK(alone.exit_code == 1);
  CHECK_MESSAGE(is_error_line(alone.err, "rig-host", {"descriptor 3 cannot be read"}), alone.err);
  const ToolRun command = run_tool({"sample", "exec:exit 3", "--out", "/no/such/poses"});
  CHECK(command.exit_code == 1);
  CHECK_MESSAGE(
      is_error_line(command.err, "sample", {"exec:exit 3: its process ended with exit code 3 before it said hello"}),
      command.err);
}

}  // namespace test_tool_rigs
