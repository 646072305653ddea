// Whichever call of the file system fails, a command says so, naming the path, and leaves each of its outputs as it was
// or complete; once the fault is gone, the same command leaves exactly what an undisturbed one does.
#include <doctest/doctest.h>

#include <cerrno>

#include "base/file.h"
#include "fault_commands.h"

namespace fs = std::filesystem;

namespace {

struct Fault {
  const char* name;
  const char* kinds;  // of calls, as in failing_calls.c
  int error;          // errno, or 0: the folder vanishes
  bool stays;         // all later calls fail too
  bool fatal;         // no command can succeed
};

const Fault faults_tried[] = {
    {"the disk is full", "create,write,mkdir", ENOSPC, true, true},
    {"writing fails", "create,write,sync,rename,mkdir,truncate", EIO, false, true},
    {"reading fails", "open,read", EIO, false, false},
    {"removing fails", "remove", EIO, false, false},
    {"the folder vanishes", "open,create,read,write,sync,rename,mkdir,truncate,remove,lock", 0, false, false},
};

// After lines of progress.
std::string last_line(const std::string& text) {
  const std::size_t before = text.size() < 2 ? std::string::npos : text.rfind('\n', text.size() - 2);
  return before == std::string::npos ? text : text.substr(before + 1);
}

class Tries {
 public:
  Tries(const faults::Workbench& bench, const faults::Command& command)
      : bench_(bench), command_(command), expected_(bench.expect(command)) {}

  // Runs the command with this fault at every call, or at every so many-th: until the fault is never met.
  int run(const Fault& fault, int every) {
    int tried = 0;
    for (int call = 1; at(fault, call); call += every) ++tried;
    return tried;
  }

 private:
  // False if the command has fewer calls.
  bool at(const Fault& fault, int call) {
    bench_.reset();
    const std::string mark = bench_.out() + ".mark";
    fs::remove(mark);
    ToolSetting setting;
    setting.environment = {"LD_PRELOAD=" FB_FAILING_CALLS,
                           "FB_FAULT_FOLDER=" + bench_.out(),
                           std::string("FB_FAULT_KINDS=") + fault.kinds,
                           "FB_FAULT_AT=" + std::to_string(call),
                           "FB_FAULT_ERROR=" + std::to_string(fault.error),
                           "FB_FAULT_MARK=" + mark,
                           faults::preload_under_sanitizers};
    if (fault.stays) setting.environment.push_back("FB_FAULT_STAYS=1");
    const ToolRun run = bench_.run(command_, setting);
    if (!fs::exists(mark)) {
      CHECK_MESSAGE(run.exit_code == 0, run.err);
      return false;
    }
    const auto bytes = fb::read_file(mark);
    const std::string met(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    CAPTURE(met);
    CAPTURE(run.err);
    check(fault, run);
    return true;
  }

  void check(const Fault& fault, const ToolRun& run) {
    const std::string gone = bench_.out() + ".gone";
    if (fault.fatal) CHECK(run.exit_code == 1);
    if (run.exit_code != 0) CHECK(is_error_line(last_line(run.err), command_.arguments[0], {bench_.out()}));
    if (fault.error == 0) {  // what a command made where the folder was is not looked at
      REQUIRE(fs::exists(gone));
      fs::remove_all(bench_.out());
      fs::rename(gone, bench_.out());
    }
    CHECK(bench_.damage(expected_) == "");
    const ToolRun again = bench_.run(command_);
    CHECK_MESSAGE(again.exit_code == 0, again.err);
    CHECK(bench_.difference(expected_) == "");
  }

  const faults::Workbench& bench_;
  const faults::Command& command_;
  faults::Tree expected_;
};

}  // namespace

TEST_CASE("commands survive every failing call of the file system") {
  const faults::Workbench bench;
  const int every = faults::whole() ? 1 : 97;
  std::size_t pair = 0;  // of command and fault; the short form tries one in three
  for (const faults::Command& command : bench.commands()) {
    CAPTURE(command.name);
    Tries tries(bench, command);
    for (const Fault& fault : faults_tried) {
      if (pair++ % 3 != 0 && !faults::whole()) continue;
      CAPTURE(std::string(fault.name));
      const int tried = tries.run(fault, every);
      MESSAGE(command.name, ", ", std::string(fault.name), ": ", tried, " calls failed");
      CHECK((tried > 0 || !fault.fatal));
    }
  }
}
