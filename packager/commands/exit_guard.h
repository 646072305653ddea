#pragma once

#include <string>

namespace fb::tool {

// While it lives, whoever else in the process calls exit() or quick_exit(), such as a rig, ends it with exit code 1 and
// a message that begins with `command`: the work was not done. One at a time.
class ExitGuard {
 public:
  explicit ExitGuard(std::string command);
  ~ExitGuard();
  ExitGuard(const ExitGuard&) = delete;
  ExitGuard& operator=(const ExitGuard&) = delete;
};

}  // namespace fb::tool
