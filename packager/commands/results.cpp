#include "commands/results.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

#include "base/status.h"

namespace fb::tool {
namespace {

constexpr int least_descriptor = 10;  // those before it may be the pipes of the rig protocol
std::FILE* results = nullptr;         // null: standard output was closed

void check(bool written) {
  if (!written) fail(Status::io, "standard output: writing failed");
}

}  // namespace

void reserve_standard_output() {
  const int kept = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, least_descriptor);
  if (kept >= 0) results = ::fdopen(kept, "w");
  if (::dup2(STDERR_FILENO, STDOUT_FILENO) < 0) ::close(STDOUT_FILENO);
}

int results_descriptor() {
  return results ? ::fileno(results) : -1;
}

void print_result(const std::string& text) {
  check(results && std::fputs(text.c_str(), results) >= 0);
}

void finish_results() {
  check(!results || (std::fflush(results) == 0 && !std::ferror(results)));
}

}  // namespace fb::tool
