// Commands that write, and what they must leave behind.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "tool_files.h"
#include "tool_run.h"

namespace faults {

// Whether FB_FAULTS=whole asks for the long form of the tests.
bool whole();

// A variable for commands that run with a preloaded library: the address sanitizer wants to be the first otherwise.
inline constexpr const char* preload_under_sanitizers = "ASAN_OPTIONS=verify_asan_link_order=0";

// Files by their names below a folder, with their bytes; folders end in "/".
using Tree = std::map<std::string, std::vector<std::byte>>;

Tree tree_of(const std::string& folder);

// A command that writes below one folder, `out`, which it finds in the same state before each try.
struct Command {
  std::string name;
  std::vector<std::string> arguments;
  std::vector<std::string> environment = {};  // "NAME=VALUE"
  bool slow = false;                          // takes half a second or more
};

// Which commands: those that stand for all, or one for every writer of a file. FB_FAULTS=whole adds some to both.
enum class Extent { usual, all_writers };

// Inputs, and commands that turn them into outputs.
class Workbench {
 public:
  explicit Workbench(Extent extent = Extent::usual);

  // Of all commands that write, small ones.
  const std::vector<Command>& commands() const { return commands_; }
  const std::string& out() const { return out_; }
  // Puts the folder into its first state: an old archive.
  void reset() const;
  ToolRun run(const Command& command, const ToolSetting& setting = {}) const;
  // Resets, runs the command and returns what it leaves.
  Tree expect(const Command& command) const;

  // What is wrong with the folder after a command that may have been stopped anywhere; "" if every file is as before or
  // as expected, other than work files.
  std::string damage(const Tree& expected) const;
  // The same after a command that succeeded: nothing is missing, nothing is left over.
  std::string difference(const Tree& expected) const;

 private:
  ScratchFolder folder_;
  std::string out_;
  std::vector<std::byte> old_;
  std::vector<Command> commands_;

  void add_writers(const std::string& face, const std::string& clip, const std::string& toy,
                   const std::string& recorded);
};

}  // namespace faults
