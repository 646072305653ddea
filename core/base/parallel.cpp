#include "base/parallel.h"

#include <algorithm>
#include <exception>
#include <mutex>

#ifdef _OPENMP
#include <omp.h>

#include <atomic>

#include "base/forked_child.h"
#include "base/thread_team.h"
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

// What OpenMP said last; 0: it was not asked.
std::atomic<int> default_threads{0};

std::size_t default_workers() {
  if (!in_forked_child())
    default_threads = omp_get_max_threads();
  else if (default_threads == 0)
    return workers_by_environment();
  return static_cast<std::size_t>(std::max(1, default_threads.load()));
}

// How many threads, up to `wanted`, the system lets run at once beside those there are.
std::size_t count_possible_threads(std::size_t wanted) {
  std::atomic<bool> ended{false};
  const auto wait = [&](std::size_t) { ended.wait(false); };
  const ThreadTeam team(wanted, wait);
  ended = true;
  ended.notify_all();
  return team.count();
}

// The number of workers a loop can have, up to `wanted`. Where OpenMP cannot create a thread, it ends the process; so
// threads it does not have yet are created for trial. OpenMP keeps as many threads for each thread that runs loops as
// its last loop had.
std::size_t possible_workers(std::size_t wanted) {
  thread_local std::size_t kept = 1;
  if (omp_in_parallel()) return 1;
  if (wanted > kept) {
    // One more, so that there is memory left beside the threads.
    const std::size_t more = count_possible_threads(wanted - kept + 1);
    wanted = std::min(wanted, kept + (more > 0 ? more - 1 : 0));
  }
  return kept = wanted;
}

thread_local bool in_team_loop = false;

// Without OpenMP, which a child made by fork() cannot use: it would wait for ever for threads that only the parent
// has, or for locks that other threads held.
void run_with_team(Loop& loop, std::size_t count, std::size_t workers) {
  std::atomic<std::size_t> next{0};
  const auto work = [&](std::size_t worker) {
    in_team_loop = true;
    for (std::size_t index = next++; index < count; index = next++) loop.run(index, worker);
    in_team_loop = false;
  };
  const auto work_beside = [&](std::size_t thread) { work(thread + 1); };
  const ThreadTeam team(workers - 1, work_beside);
  work(0);
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
  std::size_t workers = std::min(worker_count(parallel), count);
#ifdef _OPENMP
  const bool with_team = workers > 1 && !parallel.host && in_forked_child();
  if (with_team && in_team_loop) workers = 1;
  if (workers > 1 && !parallel.host && !with_team) workers = possible_workers(workers);
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
  } else if (workers > 1 && with_team) {
    run_with_team(loop, count, workers);
  } else if (workers > 1) {
    run_with_openmp(loop, count, workers);
#endif
  } else {
    for (std::size_t index = 0; index < count; ++index) loop.run(index, 0);
  }
  if (loop.exception) std::rethrow_exception(loop.exception);
}

}  // namespace fb
