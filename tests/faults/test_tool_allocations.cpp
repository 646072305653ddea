// Whichever allocation fails while a command writes, it ends with an error or does its work all the same; it leaves
// each of its outputs as it was or complete.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "base/file.h"
#include "fault_commands.h"

namespace fs = std::filesystem;

namespace {

// Runs a command with the allocation of this number failing (0: none). `count`: how many it made until its end.
ToolRun run_with_failing(const faults::Workbench& bench, const faults::Command& command, long at,
                         long* count = nullptr) {
  bench.reset();
  const std::string mark = bench.out() + ".mark";
  fs::remove(mark);
  ToolSetting setting;
  setting.environment = {"LD_PRELOAD=" FB_FAILING_ALLOCATIONS, "FB_FAULT_PROGRAM=facebaker",
                         "FB_FAULT_AT=" + std::to_string(at), "FB_FAULT_MARK=" + mark};
  const ToolRun run = bench.run(command, setting);
  if (count) {
    const auto bytes = fb::read_file(mark);
    *count = std::atol(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()).c_str());
  }
  return run;
}

// Numbers of allocations: some over the whole run, and of the last ones, when outputs are written, all or one in 80.
std::vector<long> chosen(long count) {
  const long most = faults::whole() ? 3000 : 3, last = 500, every = faults::whole() ? 1 : 80;
  std::vector<long> numbers;
  for (long i = 0; i < std::min(most, count); ++i) numbers.push_back(1 + count * i / std::min(most, count));
  for (long at = std::max(1L, count - last); at < count; at += every) numbers.push_back(at);
  std::ranges::sort(numbers);
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  return numbers;
}

void fail_allocations(const faults::Workbench& bench, const faults::Command& command) {
  const faults::Tree expected = bench.expect(command);
  long count = 0;
  CHECK(run_with_failing(bench, command, 0, &count).exit_code == 0);
  CHECK(count > 100);
  int refused = 0;
  const std::vector<long> numbers = chosen(count);
  for (const long at : numbers) {
    CAPTURE(at);
    const ToolRun run = run_with_failing(bench, command, at);
    CAPTURE(run.err);
    CHECK((run.exit_code == 0 || run.exit_code == 1));
    if (run.exit_code == 0) CHECK(bench.difference(expected) == "");
    const auto says = [&](const char* words) { return run.err.find(words) != std::string::npos; };
    // The loader of plugins does not always say what it had too little of.
    if (run.exit_code == 1) CHECK((says("memory") || says("cannot be loaded")));
    CHECK(bench.damage(expected) == "");
    refused += run.exit_code != 0;
  }
  CHECK(refused > 0);
  MESSAGE(command.name, ": ", refused, " of ", numbers.size(), " tried allocations refused, of ", count);
}

}  // namespace

TEST_CASE("commands that write survive failing allocations") {
  static const faults::Workbench bench(faults::Extent::all_writers);
  for (const faults::Command& command : bench.commands()) {
    if (command.slow && !faults::whole()) continue;
    SUBCASE(command.name.c_str()) {
      fail_allocations(bench, command);
    }
  }
}
