#include "bake/rig_process/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <thread>

#include "bake/rig_process/rig_messages.h"
#include "base/orphan_guard.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::bake {
namespace {

// Descriptors of the child that ours must not collide with.
constexpr int least_own_descriptor = 10;

struct Pipe {
  OpenDescriptor read, write;
};

Pipe make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail(Status::io, "a pipe cannot be made: %s", ::strerror(errno));
  Pipe pipe{OpenDescriptor(ends[0]), OpenDescriptor(ends[1])};
  for (OpenDescriptor* end : {&pipe.read, &pipe.write}) {
    const int moved = ::fcntl(end->get(), F_DUPFD_CLOEXEC, least_own_descriptor);
    if (moved < 0) fail(Status::io, "a pipe cannot be made: %s", ::strerror(errno));
    *end = OpenDescriptor(moved);
  }
  return pipe;
}

std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

// Our environment, with the descriptors of the protocol.
std::vector<std::string> child_environment() {
  std::vector<std::string> variables;
  const std::string requests = std::string(rig_requests_variable) + "=",
                    answers = std::string(rig_answers_variable) + "=";
  for (char** variable = environ; *variable; ++variable)
    if (std::string_view(*variable).substr(0, requests.size()) != requests &&
        std::string_view(*variable).substr(0, answers.size()) != answers)
      variables.emplace_back(*variable);
  variables.push_back(requests + std::to_string(rig_requests_descriptor));
  variables.push_back(answers + std::to_string(rig_answers_descriptor));
  return variables;
}

// How to start a child: its descriptors, its group, and all signals as they are by default.
class SpawnSetting {
 public:
  SpawnSetting(int requests, int answers) {
    ::posix_spawn_file_actions_init(&files_);
    ::posix_spawn_file_actions_addopen(&files_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (::fcntl(STDERR_FILENO, F_GETFD) < 0)
      ::posix_spawn_file_actions_addopen(&files_, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    ::posix_spawn_file_actions_adddup2(&files_, STDERR_FILENO, STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&files_, requests, rig_requests_descriptor);
    ::posix_spawn_file_actions_adddup2(&files_, answers, rig_answers_descriptor);
#if defined(__GLIBC_PREREQ)
#if __GLIBC_PREREQ(2, 34)
    ::posix_spawn_file_actions_addclosefrom_np(&files_, rig_answers_descriptor + 1);
#endif
#endif
    ::posix_spawnattr_init(&attributes_);
    sigset_t signals;
    sigfillset(&signals);
    ::posix_spawnattr_setsigdefault(&attributes_, &signals);
    sigemptyset(&signals);
    ::posix_spawnattr_setsigmask(&attributes_, &signals);
    ::posix_spawnattr_setpgroup(&attributes_, 0);
    ::posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  }
  ~SpawnSetting() {
    ::posix_spawn_file_actions_destroy(&files_);
    ::posix_spawnattr_destroy(&attributes_);
  }
  SpawnSetting(const SpawnSetting&) = delete;
  SpawnSetting& operator=(const SpawnSetting&) = delete;
  const posix_spawn_file_actions_t* files() const {
    return &files_;
  }
  const posix_spawnattr_t* attributes() const {
    return &attributes_;
  }

 private:
  posix_spawn_file_actions_t files_;
  posix_spawnattr_t attributes_;
};

void set_non_blocking(int descriptor) {
  ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) | O_NONBLOCK);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command) {
  Pipe to_child = make_pipe(), from_child = make_pipe();
  const SpawnSetting setting(to_child.read.get(), from_child.write.get());
  std::vector<std::string> words = command, variables = child_environment();
  prepare_guard();
  const int failed = ::posix_spawnp(&pid_, words.at(0).c_str(), setting.files(), setting.attributes(),
                                    pointers_to(words).data(), pointers_to(variables).data());
  if (failed != 0) {
    pid_ = -1;
    fail(Status::rig, "%s cannot be started: %s", shown(words[0]).c_str(), ::strerror(failed));
  }
  guard_group(pid_);
  requests_ = std::move(to_child.write);
  answers_ = std::move(from_child.read);
  set_non_blocking(requests_.get());
  set_non_blocking(answers_.get());
}

ChildProcess::~ChildProcess() {
  end();
}

bool ChildProcess::wait_for_end(std::chrono::milliseconds patience) const {
  const auto until = std::chrono::steady_clock::now() + patience;
  for (;;) {
    siginfo_t ended = {};
    // Not reaped, so that its number stays that of the group.
    if (::waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) != 0 || ended.si_pid != 0)
      return true;
    if (std::chrono::steady_clock::now() >= until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

std::string ChildProcess::end() {
  if (pid_ < 0) return {};
  ::kill(-pid_, SIGKILL);
  release_group(pid_);
  int status = 0;
  while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) continue;
  pid_ = -1;
  if (WIFSIGNALED(status))
    return format("was ended by signal %d (%s)", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
  return format("ended with exit code %d", WEXITSTATUS(status));
}

}  // namespace fb::bake
