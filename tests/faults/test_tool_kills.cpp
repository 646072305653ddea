// A command that is killed or interrupted at any moment leaves each of its outputs as it was or complete, and the same
// command run again leaves exactly what an undisturbed one does.
#include <doctest/doctest.h>

#include <chrono>

#include "base/random.h"
#include "fault_commands.h"

namespace {

using Clock = std::chrono::steady_clock;

// Stops the command at random moments of its run time; returns how often it was stopped before its end.
int stop_at_random_moments(const faults::Workbench& bench, const faults::Command& command, int signal, int moments) {
  const auto start = Clock::now();
  const faults::Tree expected = bench.expect(command);
  const auto whole = std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - start).count();
  fb::Random random(static_cast<std::uint64_t>(signal));
  int stopped = 0;
  for (int moment = 0; moment < moments; ++moment) {
    bench.reset();
    ToolSetting setting;
    setting.signal = signal;
    setting.signal_after_us = static_cast<int>(random.uniform() * static_cast<float>(whole));
    CAPTURE(setting.signal_after_us);
    stopped += bench.run(command, setting).exit_code != 0;
    CHECK(bench.damage(expected) == "");
    const ToolRun again = bench.run(command);
    CHECK_MESSAGE(again.exit_code == 0, again.err);
    CHECK(bench.difference(expected) == "");
  }
  return stopped;
}

}  // namespace

TEST_CASE("commands stopped at any moment can be run again, to the same bytes") {
  const faults::Workbench bench;
  const int moments = faults::whole() ? 30 : 1;
  for (const faults::Command& command : bench.commands()) {
    CAPTURE(command.name);
    const int killed = stop_at_random_moments(bench, command, SIGKILL, moments);
    const int interrupted = stop_at_random_moments(bench, command, SIGINT, moments);
    MESSAGE(command.name, ": ", killed, " killed and ", interrupted, " interrupted before the end, of ", moments);
  }
}
