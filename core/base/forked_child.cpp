#include "base/forked_child.h"

#include <algorithm>
#include <cstdlib>
#include <thread>

#ifndef _WIN32
#include <pthread.h>

#include <atomic>
#endif
#ifdef __linux__
#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstring>

#include "base/open_descriptor.h"
#endif

namespace fb {

#ifdef _WIN32

bool in_forked_child() {
  return false;  // there is no fork()
}

#else
namespace {

std::atomic<bool> forked{false};
const bool forks_are_noticed = pthread_atfork(nullptr, nullptr, [] { forked = true; }) == 0;

#ifdef __linux__

// The system's flag PF_FORKNOEXEC, among those that proc(5) calls "flags".
bool forked_before_loading() {
  const OpenDescriptor file(open("/proc/self/stat", O_RDONLY | O_CLOEXEC));
  std::array<char, 1024> text{};
  if (file.get() < 0 || read(file.get(), text.data(), text.size() - 1) <= 0) return true;
  const char* const name_end = std::strrchr(text.data(), ')');  // names may have any characters
  unsigned flags = 0;
  if (!name_end || std::sscanf(name_end, ") %*c %*d %*d %*d %*d %*d %u", &flags) != 1) return true;
  constexpr unsigned fork_no_exec = 0x40;
  return flags == 0 || (flags & fork_no_exec) != 0;  // some that imitate Linux have no flags
}

#else

bool forked_before_loading() {
  return false;
}

#endif
}  // namespace

bool in_forked_child() {
  if (forked || !forks_are_noticed) return true;
  static const bool before = forked_before_loading();
  return before;
}

#endif

std::size_t workers_by_environment() {
  const char* const asked = std::getenv("OMP_NUM_THREADS");
  const long number = asked ? std::strtol(asked, nullptr, 10) : 0;  // the first of "4,2", which are levels
  if (number > 0) return static_cast<std::size_t>(number);
#ifdef __linux__
  cpu_set_t processors;
  if (sched_getaffinity(0, sizeof processors, &processors) == 0)
    return static_cast<std::size_t>(std::max(1, CPU_COUNT(&processors)));
#endif
  return std::max(1U, std::thread::hardware_concurrency());
}

}  // namespace fb
