#include "tool_run.h"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>

namespace {

// An unnamed file that takes what a process prints.
class Capture {
 public:
  Capture() {
    char name[] = "/tmp/facebaker-print-XXXXXX";
    descriptor_ = mkstemp(name);
    if (descriptor_ < 0) throw std::runtime_error("no temporary file");
    unlink(name);
  }
  ~Capture() { close(descriptor_); }
  int descriptor() const { return descriptor_; }
  std::string text() const {
    lseek(descriptor_, 0, SEEK_SET);
    std::string text;
    std::array<char, 4096> block;
    for (ssize_t got; (got = read(descriptor_, block.data(), block.size())) > 0;) text.append(block.data(), got);
    return text;
  }

 private:
  int descriptor_;
};

[[noreturn]] void become(std::vector<char*>& arguments, int out, int err, const ToolSetting& setting) {
  if (!setting.standard_output.empty()) out = open(setting.standard_output.c_str(), O_WRONLY);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  if (setting.largest_file) {
    const rlimit limit = {setting.largest_file, setting.largest_file};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  for (const std::string& variable : setting.environment) putenv(strdup(variable.c_str()));
  execv(arguments[0], arguments.data());
  _exit(127);
}

// True if the path is there and, where bytes are asked for, a file of at least so many.
bool is_there(const std::string& path, unsigned long bytes) {
  struct stat status = {};
  return stat(path.c_str(), &status) == 0 && (bytes == 0 || static_cast<unsigned long>(status.st_size) >= bytes);
}

}  // namespace

ToolRun run_program(const std::string& path, const std::vector<std::string>& arguments, const ToolSetting& setting) {
  std::vector<std::string> words = {path};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const Capture out, err;
  // A signal that comes before the child has become the program must not meet a handler of this one.
  sigset_t signals, before;
  sigfillset(&signals);
  pthread_sigmask(SIG_SETMASK, &signals, &before);
  const pid_t child = fork();
  if (child == 0) {
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) signal(number, SIG_DFL);
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    become(pointers, out.descriptor(), err.descriptor(), setting);
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (child < 0) throw std::runtime_error("fork failed");
  using Clock = std::chrono::steady_clock;
  Clock::time_point signalled;
  if (!setting.interrupt_when_exists.empty()) {
    // Until the path is there or the child is gone, which is left for wait4 below to find.
    siginfo_t gone = {};
    while (!is_there(setting.interrupt_when_exists, setting.interrupt_when_bytes) && gone.si_pid == 0) {
      waitid(P_PID, child, &gone, WEXITED | WNOHANG | WNOWAIT);
      usleep(2000);
    }
    signalled = Clock::now();
    kill(child, setting.signal);
  }
  if (setting.signal_after_us >= 0) {
    usleep(static_cast<useconds_t>(setting.signal_after_us));
    signalled = Clock::now();
    kill(child, setting.signal);  // the child is still ours: nobody has waited for it
  }
  int status = 0;
  rusage usage = {};
  wait4(child, &status, 0, &usage);
  ToolRun run{WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), out.text(), err.text()};
  if (signalled != Clock::time_point{})
    run.seconds_to_end = std::chrono::duration<double>(Clock::now() - signalled).count();
  run.peak_bytes = 1024 * static_cast<std::size_t>(usage.ru_maxrss);
  return run;
}

ToolRun run_tool(const std::vector<std::string>& arguments, const ToolSetting& setting) {
  return run_program(FB_TOOL, arguments, setting);
}

bool is_error_line(const std::string& err, const std::string& command, const std::vector<std::string>& words) {
  const bool one_line = std::count(err.begin(), err.end(), '\n') == 1 && err.back() == '\n';
  return one_line && err.starts_with("facebaker " + command + ": ") &&
         std::all_of(words.begin(), words.end(), [&](const auto& word) { return err.find(word) != std::string::npos; });
}
