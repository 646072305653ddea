// Two runs that write the same output: one does its work, the other says who is at it.
#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <thread>

#include "base/file.h"
#include "base/output_lock.h"
#include "base/random.h"
#include "fault_commands.h"

TEST_CASE("no command writes what another process is writing") {
  const faults::Workbench bench;
  const std::string holder = ": is being written by process " + std::to_string(getpid()) + " on ";
  for (const faults::Command& command : bench.commands()) {
    CAPTURE(command.name);
    int locked = 0;
    for (const std::string option : {"--out", "--work", "--report", "--csv", "--json"}) {
      const auto at = std::find(command.arguments.begin(), command.arguments.end(), option);
      if (at == command.arguments.end()) continue;
      ++locked;
      bench.reset();
      const bool folder = option == "--work" || option == "--report" || command.arguments[0] == "sample";
      const fb::OutputLock lock = folder ? fb::OutputLock::of_folder(at[1]) : fb::OutputLock::of_file(at[1]);
      const faults::Tree before = faults::tree_of(bench.out());
      const ToolRun run = bench.run(command);
      CHECK(run.exit_code == 1);
      CHECK_MESSAGE(is_error_line(run.err, command.arguments[0], {at[1] + holder}), run.err);
      CHECK(faults::tree_of(bench.out()) == before);
    }
    CHECK(locked > 0);
  }
}

TEST_CASE("no command reads a dataset that another process is sampling") {
  const ScratchFolder folder;
  const std::string poses = folder / "poses", face = folder / "face.fbk";
  REQUIRE(run_tool({"sample", FB_TOY_RIG, "--out", poses, "--poses", "60"}).exit_code == 0);
  const std::vector<std::vector<std::string>> readers = {{"bake", poses, "--out", face, "--recipe", "linear"},
                                                         {"eval", face, poses, "--split", "all"}};
  for (const auto& reader : readers) CHECK(run_tool(reader).exit_code == 0);
  const std::string holder = poses + ": is being written by process " + std::to_string(getpid()) + " on ";
  {
    const fb::OutputLock lock = fb::OutputLock::of_folder(poses);
    for (const auto& reader : readers) {
      const ToolRun run = run_tool(reader);
      CHECK(run.exit_code == 1);
      CHECK_MESSAGE(is_error_line(run.err, reader[0], {holder}), run.err);
    }
  }
  for (const auto& reader : readers) CHECK(run_tool(reader).exit_code == 0);
}

TEST_CASE("without locks of the file system commands work, and a leftover must be removed by hand") {
  const faults::Workbench bench;
  const faults::Command& bake = bench.commands().at(1);
  const faults::Tree expected = bench.expect(bake);
  bench.reset();
  const std::string lock = bench.out() + "/face.fbk.facebaker-lock", mark = bench.out() + ".mark";
  ToolSetting without_locks;
  without_locks.environment = {"LD_PRELOAD=" FB_FAILING_CALLS,
                               "FB_FAULT_FOLDER=" + bench.out(),
                               "FB_FAULT_KINDS=lock",
                               "FB_FAULT_AT=1",
                               "FB_FAULT_STAYS=1",
                               "FB_FAULT_ERROR=" + std::to_string(ENOLCK),
                               "FB_FAULT_MARK=" + mark,
                               faults::preload_under_sanitizers};
  const ToolRun run = bench.run(bake, without_locks);
  CHECK_MESSAGE(run.exit_code == 0, run.err);
  CHECK(std::filesystem::exists(mark));
  CHECK(bench.difference(expected) == "");

  fb::write_file(lock, std::string("process 1 on another\x1b machine\n"));
  const ToolRun refused = bench.run(bake, without_locks);
  CHECK(refused.exit_code == 1);
  CHECK_MESSAGE(is_error_line(refused.err, "bake", {"process 1 on another  machine", "no locks", "remove " + lock}),
                refused.err);
  CHECK(bench.run(bake).exit_code == 0);
}

TEST_CASE("of two bakes to one archive, what ends well is what was asked for") {
  const ScratchFolder folder;
  const std::string out = folder / "face.fbk";
  const auto bake = [&](const std::string& to, int seed, int delay) {
    usleep(static_cast<useconds_t>(delay));
    return run_tool({"bake", FB_TOY_RIG, "--out", to, "--recipe", "linear", "--poses", "100", "--seed",
                     std::to_string(seed), "--threads", "1"});
  };
  std::vector<std::vector<std::byte>> alone;
  for (const int seed : {1, 2}) {
    REQUIRE(bake(folder / "alone.fbk", seed, 0).exit_code == 0);
    alone.push_back(fb::read_file(folder / "alone.fbk"));
  }
  REQUIRE(alone[0] != alone[1]);
  std::filesystem::remove(folder / "alone.fbk");

  fb::Random random(1);
  int refused = 0;
  const int rounds = faults::whole() ? 100 : 3;
  for (int round = 0; round < rounds; ++round) {
    ToolRun runs[2];
    const int delay = static_cast<int>(random.below(20000));
    std::thread other([&] { runs[1] = bake(out, 2, delay); });
    runs[0] = bake(out, 1, 0);
    other.join();
    const auto bytes = fb::read_file(out);
    CHECK((runs[0].exit_code == 0 || runs[1].exit_code == 0));
    for (int r = 0; r < 2; ++r) {
      if (runs[r].exit_code == 0) continue;
      CHECK_MESSAGE(is_error_line(runs[r].err, "bake", {out + ": is being written by process "}), runs[r].err);
      CHECK(bytes == alone[1 - r]);
      ++refused;
    }
    CHECK((bytes == alone[0] || bytes == alone[1]));
    CHECK(folder.names() == std::vector<std::string>{"face.fbk"});
  }
  MESSAGE(refused, " of ", rounds, " rounds had a bake refused");
  CHECK(refused > 0);
}
