#include "commands/results.h"

#include "commands/own_text.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <new>

#include "base/status.h"
#include "base/visible_text.h"

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
  // A file that is written must not become what others take for a standard stream.
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", O_RDWR);
  if (kept >= 0 && !(results = ::fdopen(kept, "w"))) throw std::bad_alloc();
  if (::dup2(STDERR_FILENO, STDOUT_FILENO) < 0) ::close(STDOUT_FILENO);
}

int results_descriptor() {
  return results ? ::fileno(results) : -1;
}

void print_result(const std::string& text) {
  print_own_text(visible_text(text, Layout::kept));
}

void print_own_text(const std::string& text) {
  check(results && std::fputs(text.c_str(), results) >= 0);
}

void finish_results() {
  check(!results || (std::fflush(results) == 0 && !std::ferror(results)));
}

}  // namespace fb::tool
