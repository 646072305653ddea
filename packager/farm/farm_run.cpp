#include "farm/farm_run.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <list>
#include <optional>
#include <thread>

#include "base/open_descriptor.h"
#include "base/orphan_guard.h"
#include "base/output_lock.h"
#include "base/shown_path.h"
#include "base/status.h"

namespace fb::tool {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds asking_interval{20};

// Begins a log with the command.
OpenDescriptor begin_log(const std::filesystem::path& path, const std::string& command) {
  OpenDescriptor log(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0666));
  const std::string line = command + "\n";
  if (log.get() < 0 || ::write(log.get(), line.data(), line.size()) != static_cast<ssize_t>(line.size()))
    fail(Status::io, "%s: cannot be written: %s", shown(path).c_str(), ::strerror(errno));
  return log;
}

// A character being baked.
class FarmJob {
 public:
  FarmJob(const FarmFolder& folder, const FarmCharacter& character, const FarmRun& run);
  // The exit code, once it has ended.
  std::optional<int> ended();
  void stop() const { ::kill(pid_, SIGINT); }
  const FarmCharacter& character() const { return character_; }

 private:
  const FarmCharacter& character_;
  OutputLock lock_;
  OpenDescriptor log_;
  const Clock::time_point begun_ = Clock::now();
  pid_t pid_ = -1;
};

FarmJob::FarmJob(const FarmFolder& folder, const FarmCharacter& character, const FarmRun& run)
    : character_(character),
      lock_(OutputLock::of_file(folder.log(character))),
      log_(begin_log(folder.log(character), folder.command_line(character, run.more))) {
  std::vector<std::string> words = folder.arguments(character, run.more);
  words.insert(words.begin(), run.program);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&files, log_.get(), STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&files, log_.get(), STDERR_FILENO);
  // In a process group of its own, so that Ctrl-C reaches it once, from here.
  posix_spawnattr_t how;
  ::posix_spawnattr_init(&how);
  ::posix_spawnattr_setflags(&how, POSIX_SPAWN_SETPGROUP);
  prepare_guard();
  const int error = ::posix_spawn(&pid_, run.program.c_str(), &files, &how, arguments.data(), ::environ);
  ::posix_spawnattr_destroy(&how);
  ::posix_spawn_file_actions_destroy(&files);
  if (error != 0) fail(Status::io, "%s: cannot be started: %s", shown(run.program).c_str(), ::strerror(error));
  guard_group(pid_);  // which does not outlive a farm that is killed
}

std::optional<int> FarmJob::ended() {
  siginfo_t gone = {};
  if (::waitid(P_PID, static_cast<id_t>(pid_), &gone, WEXITED | WNOHANG | WNOWAIT) != 0 || gone.si_pid != pid_)
    return std::nullopt;
  release_group(pid_);
  int status = 0;
  ::waitpid(pid_, &status, 0);
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  const std::string line =
      FarmFolder::end_line(code, std::chrono::duration<double>(Clock::now() - begun_).count()) + "\n";
  if (::write(log_.get(), line.data(), line.size()) != static_cast<ssize_t>(line.size()))
    fail(Status::io, "the log of %s cannot be written: %s", character_.name.c_str(), ::strerror(errno));
  return code;
}

}  // namespace

void run_farm(const FarmFolder& folder, const std::vector<FarmCharacter>& characters, const FarmRun& run) {
  std::list<FarmJob> jobs;
  std::size_t next = 0, over = 0;
  const auto is_running = [&](const FarmCharacter& character) {
    return folder.status(character).state == FarmState::running;
  };
  const auto begin = [&](const FarmCharacter& character) {
    try {
      if (!is_running(character)) {
        jobs.emplace_back(folder, character, run);
        return run.tell(character.name + ": begun, its log is " + shown(folder.log(character)));
      }
    } catch (const Error&) {
      if (!is_running(character)) throw;  // else another process was quicker
    }
    ++over;
    run.tell(character.name + ": is being baked by another process");
  };
  const auto tell_end = [&](const FarmCharacter& character, int code) {
    const FarmStatus status = folder.status(character);
    run.tell(format("%s: %s%s (%zu of %zu)", character.name.c_str(), code == 0 ? "done" : name_of(status.state),
                    status.message.empty() ? "" : (": " + status.message).c_str(), ++over, characters.size()));
  };
  bool stopping = false;
  while (!jobs.empty() || (next < characters.size() && !stopping)) {
    if (!stopping && run.stop()) {
      stopping = true;
      for (const FarmJob& job : jobs) job.stop();
    }
    while (!stopping && jobs.size() < run.jobs && next < characters.size()) begin(characters[next++]);
    for (auto job = jobs.begin(); job != jobs.end();) {
      const FarmCharacter& character = job->character();
      const std::optional<int> code = job->ended();
      job = code ? jobs.erase(job) : std::next(job);  // which gives the lock of the log back
      if (code) tell_end(character, *code);
    }
    std::this_thread::sleep_for(asking_interval);
  }
}

}  // namespace fb::tool
