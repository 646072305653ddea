#pragma once

#include <signal.h>

#include <cstddef>
#include <string>
#include <vector>

struct ToolRun {
  int exit_code = -1;  // 128 + signal if one ended it
  std::string out, err;
  double seconds_to_end = 0;   // from the signal that was sent to the end; 0 without one
  std::size_t peak_bytes = 0;  // of memory that it had at once
};

// Under a limit on file sizes clang's OpenMP runtime and ThreadSanitizer, which map files of their own, die of a bus error;
// the first leaves an empty file, too, of which a later program of the same process number dies.
#ifdef __clang__
inline constexpr bool can_limit_files = false;
#else
inline constexpr bool can_limit_files = true;
#endif

struct ToolSetting {
  std::string standard_output = {};           // where it goes instead of ToolRun::out; empty: nowhere else
  unsigned long largest_file = 0;             // bytes any file may grow to before writing fails; 0: no limit
                                              // (see can_limit_files)
  std::vector<std::string> environment = {};  // more variables, "NAME=VALUE"
  std::string interrupt_when_exists = {};     // Ctrl-C once this path is there
  unsigned long interrupt_when_bytes = 0;     // and holds so many bytes; 0: whatever it is
  int signal = SIGINT;                        // in place of Ctrl-C
  int signal_after_us = -1;                   // that signal after so many microseconds; negative: never
};

// Runs a program with these arguments and waits for it.
ToolRun run_program(const std::string& path, const std::vector<std::string>& arguments,
                    const ToolSetting& setting = {});

// Runs build/.../facebaker with these arguments and waits for it.
ToolRun run_tool(const std::vector<std::string>& arguments, const ToolSetting& setting = {});

// True if the message is one line "facebaker COMMAND: ..." that has all these words in it.
bool is_error_line(const std::string& err, const std::string& command, const std::vector<std::string>& words);
