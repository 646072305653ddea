#include "commands/exit_guard.h"

#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace fb::tool {
namespace {

std::atomic<bool> working{false};
std::string command_name;  // never destroyed before the handler has run: it is registered later

void end_with_failure() {
  if (!working) return;
  std::fprintf(stderr, "%s: a rig or a library ended the program before its work was done\n", command_name.c_str());
  ::_exit(1);
}

}  // namespace

ExitGuard::ExitGuard(std::string command) {
  command_name = std::move(command);
  working = true;
  std::atexit(end_with_failure);
  std::at_quick_exit(end_with_failure);
}

ExitGuard::~ExitGuard() {
  working = false;
}

}  // namespace fb::tool
