// What a rig answered before it was edited, as a user of the tool reuses it.
#include <doctest/doctest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/file.h"
#include "tool_files.h"
#include "tool_run.h"

namespace test_tool_reuse {

namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// Bakes the slow toy rig, of version 1 or of 2, in which browTwist moves vertex 0 otherwise.
ToolRun bake(int version, const ScratchFolder& folder, const std::string& name, std::vector<std::string> more,
             int signal_after_us = -1) {
  ToolSetting setting;
  setting.environment = {version == 1 ? "FB_FAULT=slow with a version" : "FB_FAULT=slow with another version"};
  setting.signal_after_us = signal_after_us;
  std::vector<std::string> arguments = {"bake",       FB_FAULTY_RIG, "--out",   folder / (name + ".fbk"),
                                        "--recipe",   "linear",      "--poses", "300",
                                        "--use",      "variant",     "--json",  "--work",
                                        folder / name};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_tool(arguments, setting);
}

}  // namespace

TEST_CASE("of a named work folder stays what a slow rig answered and the network's state, without the poses") {
  const ScratchFolder folder;
  const ToolRun run = run_tool({"bake", FB_FAULTY_RIG, "--out", folder / "face.fbk", "--recipe", "paper", "--poses",
                                "300", "--epochs", "2", "--work", folder / "work"},
                               {.environment = {"FB_FAULT=slow with a version"}});
  REQUIRE_MESSAGE(run.exit_code == 0, run.err);
  const std::filesystem::path work = folder / "work";
  CHECK(std::filesystem::exists(work / "rig.evaluations"));
  CHECK(std::filesystem::exists(work / "network.checkpoint"));
  CHECK_FALSE(std::filesystem::exists(work / "poses"));
}

TEST_CASE("after an edit of a rig, --reuse takes over what still holds, and the face is that of a whole bake") {
  const ScratchFolder folder;
  const ToolRun old = bake(1, folder, "old", {});
  REQUIRE_MESSAGE(old.exit_code == 0, old.err);
  const ToolRun whole = bake(2, folder, "whole", {});
  REQUIRE_MESSAGE(whole.exit_code == 0, whole.err);

  // In a child the rig is the same: the bake goes on, and evaluates nothing that it has.
  const ToolRun isolated = bake(1, folder, "old", {"--isolate"});
  CHECK_MESSAGE(isolated.exit_code == 0, isolated.err);
  CHECK(nlohmann::json::parse(isolated.out).at("rig_calls") < 100);

  const ToolRun refused = bake(2, folder, "old", {});
  CHECK(refused.exit_code == 1);
  for (const char* part : {"the rig declared the version \"1\" and declares \"2\"", "--reuse FOLDER"})
    CHECK_MESSAGE(contains(refused.err, part), refused.err);
  CHECK(fb::read_file(folder / "old.fbk") != fb::read_file(folder / "whole.fbk"));

  const ToolRun reused = bake(2, folder, "reused", {"--reuse", folder / "old"});
  REQUIRE_MESSAGE(reused.exit_code == 0, reused.err);
  for (const char* part : {"evaluations", "are reused and", "changed: \"browTwist\", at vertex 0 by "})
    CHECK_MESSAGE(contains(reused.err, part), reused.err);
  CHECK(fb::read_file(folder / "reused.fbk") == fb::read_file(folder / "whole.fbk"));
  const auto figures = nlohmann::json::parse(reused.out), of_whole = nlohmann::json::parse(whole.out);
  CHECK(of_whole.at("reused") == 0);
  CHECK(figures.at("reused") > 40);
  CHECK(figures.at("asked") < of_whole.at("asked"));
  CHECK(figures.at("rig_calls") < of_whole.at("rig_calls"));

  // Interrupted at some moments, the same command goes on.
  for (const int after : {150'000, 400'000, 800'000}) bake(2, folder, "stopped", {"--reuse", folder / "old"}, after);
  const ToolRun stopped = bake(2, folder, "stopped", {"--reuse", folder / "old"});
  REQUIRE_MESSAGE(stopped.exit_code == 0, stopped.err);
  CHECK(fb::read_file(folder / "stopped.fbk") == fb::read_file(folder / "whole.fbk"));
  CHECK(nlohmann::json::parse(stopped.out).at("asked") == figures.at("asked"));
  CHECK(nlohmann::json::parse(stopped.out).at("reused") == figures.at("reused"));

  const ToolRun itself = bake(2, folder, "old", {"--reuse", folder / "old"});
  CHECK_MESSAGE(is_error_line(itself.err, "bake", {"is the work folder of this bake"}), itself.err);
}

TEST_CASE("a recording has nothing to reuse, and neither has a folder that is not there") {
  const ScratchFolder folder;
  REQUIRE(run_tool({"sample", FB_TOY_RIG, "--out", folder / "poses", "--poses", "60"}).exit_code == 0);
  const ToolRun recorded = run_tool(
      {"bake", folder / "poses", "--out", folder / "face.fbk", "--recipe", "linear", "--reuse", folder.path()});
  CHECK_MESSAGE(is_error_line(recorded.err, "bake", {"is a recording: it has no evaluations to reuse"}), recorded.err);
  const ToolRun none =
      run_tool({"bake", FB_TOY_RIG, "--out", folder / "face.fbk", "--recipe", "linear", "--reuse", folder / "none"});
  CHECK_MESSAGE(is_error_line(none.err, "bake", {"none: no such folder"}), none.err);
}

TEST_CASE("a bake that is repeated evaluates no frame of the rig's clips again") {
  const ScratchFolder folder;
  const auto frames = [&] {
    const ToolRun run = bake(1, folder, "face", {});
    REQUIRE_MESSAGE(run.exit_code == 0, run.err);
    const auto figures = nlohmann::json::parse(run.out);
    for (const auto& stage : figures.at("asked_by_stage"))
      if (stage.at("stage") == "clips and test poses") return stage.at("evaluated").get<int>();
    return 0;
  };
  CHECK(frames() > 0);
  CHECK(frames() == 0);
}

TEST_CASE("what is not kept on the disk is evaluated again, and the face is the same") {
  const ScratchFolder folder;
  const auto whole = [&](const std::string& name, const std::vector<std::string>& options) {
    const ToolRun run = bake(1, folder, name, options);
    CHECK_MESSAGE(run.exit_code == 0, run.err);
    return run;
  };
  for (const std::vector<std::string>& budget : {std::vector<std::string>{}, {"--rig-budget", "60"}}) {
    std::vector<std::string> limited = budget;
    limited.insert(limited.end(), {"--cache-mib", "0"});
    const std::string kind = budget.empty() ? "free" : "budgeted", stopped = kind + " stopped";
    const auto expected = nlohmann::json::parse(whole(kind, budget).out);
    for (const int after : {150'000, 400'000, 800'000}) bake(1, folder, stopped, limited, after);
    const ToolRun run = whole(stopped, limited);
    CHECK(fb::read_file(folder / (stopped + ".fbk")) == fb::read_file(folder / (kind + ".fbk")));
    if (!budget.empty()) CHECK(nlohmann::json::parse(run.out).at("asked") == expected.at("asked"));
    CHECK(contains(run.err, "limit of 0 MiB") == budget.empty());
    // What a budget counts is kept in any case.
    CHECK(std::filesystem::exists(folder / (stopped + "/rig.evaluations")) == !budget.empty());
  }
}

}  // namespace test_tool_reuse
