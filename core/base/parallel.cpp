#include "base/parallel.h"

#include <algorithm>
#include <exception>
#include <mutex>

#ifdef _OPENMP
#include <omp.h>
#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <vector>
#endif

#include "base/openmp_date.h"
#include "base/progress.h"
#include "base/status.h"

namespace fb {
namespace {

// Keeps the exception of the lowest index, so that errors do not depend on scheduling.
struct Loop {
  LoopBody body;
  Progress* progress;
  std::mutex mutex;
  std::size_t failed = SIZE_MAX;
  std::exception_ptr exception;

  void run(std::size_t index, std::size_t worker) noexcept {
    try {
      if (progress && progress->cancelled()) progress->ask();
      body(index, worker);
      if (progress && worker == 0) progress->ask();
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (index < failed) {
        failed = index;
        exception = std::current_exception();
      }
    }
  }
};

#ifdef _OPENMP

// A child made by fork() has none of the threads that OpenMP keeps from earlier loops, and would wait for them for
// ever, or for locks of OpenMP that other threads held.
std::atomic<bool> loops_ran{false}, threads_lost{false};
std::atomic<int> asking{0};  // threads within default_workers()
#ifdef _WIN32
constexpr bool forks_are_noticed = true;  // there are none
#else
const bool forks_are_noticed = pthread_atfork(nullptr, nullptr, [] { threads_lost = loops_ran || asking > 0; }) == 0;
#endif

std::size_t default_workers() {
  if (threads_lost) return 1;
  ++asking;
  const int threads = omp_get_max_threads();
  --asking;
  return static_cast<std::size_t>(std::max(1, threads));
}

// A thread that only waits. It takes nothing from the heap, which would set aside address space for it.
struct TrialThread {
  pthread_t handle{};
  pid_t id = 0;
  std::atomic<bool>* ended = nullptr;

  bool start() {
    const auto wait = [](void* trial) -> void* {
      auto* const self = static_cast<TrialThread*>(trial);
#ifdef __linux__
      self->id = gettid();
#endif
      self->ended->wait(false);
      return nullptr;
    };
    return pthread_create(&handle, nullptr, wait, this) == 0;
  }
  void join() const {
    pthread_join(handle, nullptr);
#ifdef __linux__  // counts for limits until it is gone, a little later
    for (int tries = 0; tries < 10000 && tgkill(getpid(), id, 0) == 0; ++tries) sched_yield();
#endif
  }
};

// How many threads, up to `wanted`, the system lets run at once beside those there are.
std::size_t count_possible_threads(std::size_t wanted) {
  std::vector<TrialThread> threads(wanted);
  std::atomic<bool> ended{false};
  std::size_t count = 0;
  for (; count < wanted; ++count) {
    threads[count].ended = &ended;
    if (!threads[count].start()) break;
  }
  ended = true;
  ended.notify_all();
  for (std::size_t i = 0; i < count; ++i) threads[i].join();
  return count;
}

// The number of workers a loop can have, up to `wanted`. Where OpenMP cannot create a thread, it ends the process; so
// threads it does not have yet are created for trial. OpenMP keeps as many threads for each thread that runs loops as
// its last loop had.
std::size_t possible_workers(std::size_t wanted) {
  thread_local std::size_t kept = 1;
  loops_ran = true;
  if (threads_lost || !forks_are_noticed || omp_in_parallel()) return 1;
  if (wanted > kept) {
    // One more, so that there is memory left beside the threads.
    const std::size_t more = count_possible_threads(wanted - kept + 1);
    wanted = std::min(wanted, kept + (more > 0 ? more - 1 : 0));
  }
  return kept = wanted;
}

// On its own, because clang calls OpenMP at the beginning of a function that has a pragma.
[[gnu::noinline]] void run_with_openmp(Loop& loop, std::size_t count, std::size_t workers) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(static_cast <int>(workers))
  for (std::size_t index = 0; index < count; ++index) loop.run(index, omp_get_thread_num());
}

#endif

}  // namespace

std::size_t worker_count(const Parallel& parallel) {
#ifdef _OPENMP
  if (parallel.threads <= 0) return parallel.host ? 1 : default_workers();
  return parallel.threads;
#else
  return parallel.host && parallel.threads > 0 ? parallel.threads : 1;
#endif
}

long openmp_date() {
#ifdef _OPENMP
  return _OPENMP;
#else
  return 0;
#endif
}

void parallel_for(const Parallel& parallel, std::size_t count, LoopBody body) {
  Loop loop{body, parallel.progress, {}, SIZE_MAX, nullptr};
  [[maybe_unused]] std::size_t workers = std::min(worker_count(parallel), count);
#ifdef _OPENMP
  if (workers > 1 && !parallel.host) workers = possible_workers(workers);
#endif
  if (workers > 1 && parallel.host) {
    if (count > UINT32_MAX) fail(Status::limit, "a parallel loop of %zu items", count);
    parallel.host(
        parallel.host_user, static_cast<std::uint32_t>(count), static_cast<std::uint32_t>(workers),
        [](void* context, std::uint32_t index, std::uint32_t worker) {
          static_cast<Loop*>(context)->run(index, worker);
        },
        &loop);
#ifdef _OPENMP
  } else if (workers > 1) {
    run_with_openmp(loop, count, workers);
#endif
  } else {
    for (std::size_t index = 0; index < count; ++index) loop.run(index, 0);
  }
  if (loop.exception) std::rethrow_exception(loop.exception);
}

}  // namespace fb
