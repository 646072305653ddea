#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <vector>

#include "base/open_descriptor.h"

namespace fb::bake {

// A child process that speaks the rig protocol: with a pipe from us, its descriptor 3, and one to us, its descriptor 4,
// which two variables tell it too. Its standard input is empty, its standard output our standard error. It leads a
// process group of its own, so that Ctrl-C at the terminal does not reach it and it ends with all that it started.
class ChildProcess {
 public:
  // A program, looked up in PATH unless it has a slash, and its arguments. Fails with rig where it cannot be started.
  explicit ChildProcess(const std::vector<std::string>& command);
  // Kills the group.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // Our ends of the pipes; neither blocks.
  int requests() const { return requests_.get(); }
  int answers() const { return answers_.get(); }
  // The child reads the end of its requests.
  void close_requests() { requests_.reset(); }

  // Waits until it has ended by itself, at most so long; false if it has not.
  bool wait_for_end(std::chrono::milliseconds patience) const;
  // Kills the group, if need be, and says how it ended: "ended with exit code 3", "was ended by signal 11 (...)".
  std::string end();

 private:
  OpenDescriptor requests_, answers_;
  pid_t pid_ = -1;  // -1: waited for
};

}  // namespace fb::bake
