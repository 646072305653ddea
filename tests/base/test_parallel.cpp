#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/forked_child.h"
#include "base/openmp_date.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "base/status.h"
#include "watched_progress.h"

namespace fb::test_parallel {
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

// Whether two workers are in a loop at once, within ten seconds.
bool two_work_at_once() {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::seconds(10);
  std::atomic<int> present{0};
  std::atomic<bool> met{false};
  parallel_for({2}, 2, [&](std::size_t, std::size_t) {
    if (++present == 2) met = true;
    while (!met && Clock::now() < end) std::this_thread::yield();
    --present;
  });
  return met;
}

// What check() says in a child of fork() that has some seconds.
bool holds_in_child(const std::function<bool()>& check) {
  const pid_t child = fork();
  if (child == 0) {
    alarm(30);
    _exit(check() ? 0 : 1);
  }
  int status = 0;
  return waitpid(child, &status, 0) == child && status == 0;
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

TEST_CASE("a child of fork() has as many workers as its parent") {
  if (openmp_date() == 0) return;
  CHECK_FALSE(in_forked_child());  // a new program
  CHECK(two_work_at_once());
  const std::size_t workers = worker_count({});
  CHECK(holds_in_child([&] { return in_forked_child() && worker_count({}) == workers; }));
  CHECK(holds_in_child([] { return two_work_at_once() && holds_in_child(two_work_at_once); }));
  CHECK(holds_in_child([] { return calls_per_index({3}, 1000) == std::vector<int>(1000, 1); }));
  CHECK(holds_in_child([] {  // loops within loops are serial
    std::atomic<int> elsewhere{0};
    parallel_for({2}, 2, [&](std::size_t, std::size_t) {
      const auto outer = std::this_thread::get_id();
      parallel_for({2}, 9, [&](std::size_t, std::size_t) { elsewhere += std::this_thread::get_id() != outer; });
    });
    return elsewhere == 0;
  }));
  CHECK(holds_in_child([] {
    try {
      parallel_for({3}, 100, [](std::size_t index, std::size_t) {
        if (index % 10 == 7) fail(Status::rig, "index %zu", index);
      });
    } catch (const Error& error) {
      return std::string(error.what()) == "index 7";
    }
    return false;
  }));
  CHECK(two_work_at_once());
}

TEST_CASE("without OpenMP, the environment says how many workers there are") {
  setenv("OMP_NUM_THREADS", "3,2", 1);
  CHECK(workers_by_environment() == 3);
  unsetenv("OMP_NUM_THREADS");
  CHECK(workers_by_environment() >= 1);
  CHECK(workers_by_environment() <= std::thread::hardware_concurrency());
}

TEST_CASE("a host's scheduler without a thread count gets one worker") {
  int loops = 0;
  CHECK(worker_count({0, backwards, &loops}) == 1);
  CHECK(worker_count({6, backwards, &loops}) == 6);
}

}  // namespace fb::test_parallel
