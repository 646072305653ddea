#pragma once

#include <atomic>
#include <cstddef>

#include "base/parallel.h"
#include "base/status.h"
#include "runtime/float_mode.h"

namespace fb::runtime {

// How tasks run, the poses of a batch or parts of one: on the calling thread, or on several in the runtime's
// floating-point mode. What a host's parallel_for does is checked.
class Spread {
 public:
  Spread() = default;
  // `parallel` must outlive it, and the workers be those that it has.
  Spread(const Parallel& parallel, std::size_t workers) : parallel_(&parallel), workers_(workers) {}

  // Calls work(index, worker) for every index < count. Fails with invalid_argument if the host's parallel_for does not.
  template <class Work>
  void run(std::size_t count, const Work& work) const {
    if (!parallel_) {
      for (std::size_t i = 0; i < count; ++i) work(i, std::size_t{0});
      return;
    }
    std::atomic<std::size_t> done = 0;
    parallel_for(*parallel_, count, [&](std::size_t i, std::size_t worker) {
      if (i >= count || worker >= workers_)
        fail(Status::invalid_argument, "the host's parallel_for gave task %zu of %zu to worker %zu of %zu", i, count,
             worker, workers_);
      with_float_mode([&] { work(i, worker); });
      ++done;
    });
    if (done != count)
      fail(Status::invalid_argument, "the host's parallel_for ran %zu tasks of %zu", done.load(), count);
  }
  // Calls work(begin, end) for parts of 0..size - 1 that begin at multiples of `grain`.
  template <class Work>
  void run_ranges(std::size_t size, std::size_t grain, const Work& work) const {
    if (!parallel_) return work(std::size_t{0}, size);
    const std::size_t grains = (size + grain - 1) / grain, parts = grains < 4 * workers_ ? grains : 4 * workers_;
    run(parts, [&](std::size_t part, std::size_t) {
      const std::size_t begin = grains * part / parts * grain, end = grains * (part + 1) / parts * grain;
      work(begin, end < size ? end : size);
    });
  }

 private:
  const Parallel* parallel_ = nullptr;
  std::size_t workers_ = 1;
};

}  // namespace fb::runtime
