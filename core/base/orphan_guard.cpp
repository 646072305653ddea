#include "base/orphan_guard.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <mutex>
#include <string>
#include <utility>

#include "base/open_descriptor.h"

namespace fb {
namespace {

// Reads "+GROUP" and "-GROUP" and kills at the end of its input, which is that of whoever holds the other end. It runs
// in the background of a shell that ends at once, so that it is no child of this process.
constexpr const char* script = R"(trap '' HUP INT QUIT TERM
{
  while read -r line; do
    left=
    for group in $groups; do [ "$group" = "${line#?}" ] || left="$left $group"; done
    groups=$left
    case $line in +*) groups="$groups ${line#?}" ;; esac
  done
  for group in $groups; do kill -s KILL -- "-$group"; done
} <&3 3<&- >/dev/null 2>&1 &)";

constexpr int least_descriptor = 10;  // beyond those of the rig protocol

class Guard {
 public:
  void prepare() {
    const std::lock_guard lock(mutex_);
    if (owner_ != ::getpid()) start();
  }
  void tell(char what, pid_t group) {
    prepare();
    const std::lock_guard lock(mutex_);
    std::array<char, 32> line{};
    const int size = std::snprintf(line.data(), line.size(), "%c%ld\n", what, static_cast<long>(group));
    ::send(ours_.get(), line.data(), static_cast<std::size_t>(size), MSG_NOSIGNAL);  // it may have been killed
  }

 private:
  // Once in each process: after fork() the socket is the parent's.
  void start() {
    owner_ = ::getpid();
    ours_.reset();
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) return;
    const OpenDescriptor first(ends[0]), second(ends[1]);
    OpenDescriptor kept(::fcntl(first.get(), F_DUPFD_CLOEXEC, least_descriptor));
    const OpenDescriptor theirs(::fcntl(second.get(), F_DUPFD_CLOEXEC, least_descriptor));
    if (kept.get() >= 0 && theirs.get() >= 0 && run_script(theirs.get())) ours_ = std::move(kept);
  }

  static bool run_script(int input) {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    if (::posix_spawn_file_actions_init(&files) != 0) return false;
    if (::posix_spawnattr_init(&attributes) != 0) return ::posix_spawn_file_actions_destroy(&files) != 0;
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
      ::posix_spawn_file_actions_addopen(&files, stream, "/dev/null", O_RDWR, 0);
    ::posix_spawn_file_actions_adddup2(&files, input, 3);
    ::posix_spawnattr_setpgroup(&attributes, 0);  // not that of a terminal's Ctrl-C
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    std::array<char, 3> shell{"sh"}, option{"-c"};
    std::string text = script;
    std::array<char*, 4> words = {shell.data(), option.data(), text.data(), nullptr};
    char* const no_variables = nullptr;
    pid_t pid = -1;
    const int failed = ::posix_spawn(&pid, "/bin/sh", &files, &attributes, words.data(), &no_variables);
    ::posix_spawn_file_actions_destroy(&files);
    ::posix_spawnattr_destroy(&attributes);
    if (failed != 0) return false;
    while (::waitpid(pid, nullptr, 0) < 0 && errno == EINTR) continue;
    return true;
  }

  std::mutex mutex_;
  pid_t owner_ = -1;
  OpenDescriptor ours_;
};

Guard& guard() {
  static auto* const only = new Guard;  // never destroyed: groups may be released at the very end
  return *only;
}

void tell(char what, pid_t group) noexcept {
  try {
    guard().tell(what, group);
  } catch (...) {  // no memory: what is not guarded works all the same
  }
}

}  // namespace

void prepare_guard() noexcept {
  try {
    guard().prepare();
  } catch (...) {  // as in tell()
  }
}

void guard_group(pid_t group) noexcept {
  tell('+', group);
}

void release_group(pid_t group) noexcept {
  tell('-', group);
}

}  // namespace fb
