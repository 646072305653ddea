#include "base/keep_asking.h"

#include <chrono>
#include <future>
#include <system_error>
#include <thread>

namespace fb {
namespace {

constexpr std::chrono::milliseconds interval{100};

// Joined whatever happens: the work uses what lives on the caller's stack.
struct JoinedThread {
  std::thread thread;
  ~JoinedThread() {
    if (thread.joinable()) thread.join();
  }
};

}  // namespace

void keep_asking(Progress& progress, const std::function<void()>& work) {
  std::packaged_task<void()> task(work);
  std::future<void> done = task.get_future();
  JoinedThread worker;
  try {
    worker.thread = std::thread([&] { task(); });
  } catch (const std::system_error&) {
    task();
  }
  while (done.wait_for(interval) != std::future_status::ready) progress.ask();
  done.get();
  progress.ask();
}

}  // namespace fb
