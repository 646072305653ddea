#include "base/parallel.h"

#include <algorithm>
#include <exception>
#include <mutex>

#ifdef _OPENMP
#include <omp.h>
#endif

#include "base/status.h"

namespace fb {
namespace {

// Keeps the exception of the lowest index, so that errors do not depend on scheduling.
struct Loop {
  LoopBody body;
  std::mutex mutex;
  std::size_t failed = SIZE_MAX;
  std::exception_ptr exception;

  void run(std::size_t index, std::size_t worker) noexcept {
    try {
      body(index, worker);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (index < failed) {
        failed = index;
        exception = std::current_exception();
      }
    }
  }
};

}  // namespace

std::size_t worker_count(const Parallel& parallel) {
#ifdef _OPENMP
  if (parallel.threads <= 0) return parallel.host ? 1 : std::max(1, omp_get_max_threads());
  return parallel.threads;
#else
  return parallel.host && parallel.threads > 0 ? parallel.threads : 1;
#endif
}

void parallel_for(const Parallel& parallel, std::size_t count, LoopBody body) {
  Loop loop{body, {}, SIZE_MAX, nullptr};
  [[maybe_unused]] const std::size_t workers = std::min(worker_count(parallel), count);
  if (workers > 1 && parallel.host) {
    if (count > UINT32_MAX) fail(Status::limit, "a parallel loop of %zu items", count);
    parallel.host(
        parallel.host_user, static_cast<std::uint32_t>(count), static_cast<std::uint32_t>(workers),
        [](void* context, std::uint32_t index, std::uint32_t worker) {
          static_cast<Loop*>(context)->run(index, worker);
        },
        &loop);
#ifdef _OPENMP
  } else if (workers > 1 && !omp_in_parallel()) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(static_cast <int>(workers))
    for (std::size_t index = 0; index < count; ++index) loop.run(index, omp_get_thread_num());
#endif
  } else {
    for (std::size_t index = 0; index < count; ++index) loop.run(index, 0);
  }
  if (loop.exception) std::rethrow_exception(loop.exception);
}

}  // namespace fb
