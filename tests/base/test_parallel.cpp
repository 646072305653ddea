#include <doctest/doctest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/parallel.h"
#include "base/progress.h"
#include "base/status.h"
#include "watched_progress.h"

namespace fb {
namespace {

std::vector<int> calls_per_index(const Parallel& parallel, std::size_t count) {
  std::vector<std::atomic<int>> calls(count);
  std::vector<std::atomic<int>> busy(worker_count(parallel));
  std::atomic<bool> shared{false};
  parallel_for(parallel, count, [&](std::size_t index, std::size_t worker) {
    if (busy[worker]++ != 0) shared = true;
    ++calls[index];
    --busy[worker];
  });
  CHECK_FALSE(shared);
  return {calls.begin(), calls.end()};
}

// A scheduler that runs everything backwards and counts its loops.
void backwards(void* user, std::uint32_t count, std::uint32_t workers, HostTask task, void* context) {
  ++*static_cast<int*>(user);
  for (std::uint32_t i = count; i-- > 0;) task(context, i, i % workers);
}

}  // namespace

TEST_CASE("every index is called once and no worker twice at a time") {
  int loops = 0;
  for (const Parallel& parallel : {Parallel{}, Parallel{1}, Parallel{2}, Parallel{5}, Parallel{3, backwards, &loops}})
    for (const std::size_t count : {0, 1, 2, 1000})
      CHECK(calls_per_index(parallel, count) == std::vector<int>(count, 1));
  CHECK(loops == 2);  // not for loops of none or one
}

TEST_CASE("the exception of the lowest index is thrown, after the loop") {
  int loops = 0;
  for (const Parallel& parallel : {Parallel{1}, Parallel{4}, Parallel{2, backwards, &loops}}) {
    std::atomic<int> calls{0};
    CHECK_THROWS_WITH_AS(parallel_for(parallel, 100,
                                      [&](std::size_t index, std::size_t) {
                                        ++calls;
                                        if (index % 10 == 7) fail(Status::rig, "index %zu", index);
                                      }),
                         "index 7", Error);
    CHECK(calls == 100);
  }
}

TEST_CASE("progress is asked between items, and once it is cancelled no item begins") {
  for (const int threads : {1, 3}) {
    test::Questions progress;
    parallel_for({.threads = threads, .progress = &progress}, 300, [](std::size_t, std::size_t) {});
    if (threads == 1) CHECK(progress.asked == 300);
    test::Questions stopped;
    stopped.stop_at = 5;
    std::atomic<int> calls{0}, first_worker{0};
    try {
      // The others wait for the first worker, which is the one that asks.
      parallel_for({.threads = threads, .progress = &stopped}, 100000, [&](std::size_t, std::size_t worker) {
        ++calls;
        if (worker == 0) ++first_worker;
        while (worker != 0 && first_worker < 5) std::this_thread::yield();
      });
      FAIL("it went on");
    } catch (const Error& error) {
      CHECK(error.status() == Status::interrupted);
    }
    if (threads == 1) CHECK(calls == 5);
    CHECK(calls < 100000);
  }
}

TEST_CASE("loops within loops are serial on the outer worker") {
  std::atomic<int> calls{0};
  parallel_for({4}, 8, [&](std::size_t, std::size_t) {
    parallel_for({4}, 5, [&](std::size_t, std::size_t worker) {
      CHECK(worker < 4);
      ++calls;
    });
  });
  CHECK(calls == 40);
}

TEST_CASE("a host's scheduler without a thread count gets one worker") {
  int loops = 0;
  CHECK(worker_count({0, backwards, &loops}) == 1);
  CHECK(worker_count({6, backwards, &loops}) == 6);
}

}  // namespace fb
