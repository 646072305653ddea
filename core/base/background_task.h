#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <utility>

namespace fb {

// Work that goes on beside the caller's, on a thread of its own: one task at a time. Not thread-safe.
class BackgroundTask {
 public:
  BackgroundTask() = default;
  BackgroundTask(const BackgroundTask&) = delete;
  BackgroundTask& operator=(const BackgroundTask&) = delete;
  ~BackgroundTask() {  // waits; an exception is lost
    if (task_.valid()) task_.wait();
  }

  // Begins work() once the task before it is done. Throws what that one has thrown. Where no thread can be made, the
  // work is done by the next call, on the caller's thread.
  void begin(std::function<void()> work) {
    finish();
    task_ = std::async(std::launch::async | std::launch::deferred, std::move(work));
  }

  // Waits for the task, as long as `time` at most. Whether finish() has none to wait for: it is done, or done by
  // finish().
  bool ends_within(std::chrono::milliseconds time) {
    return !task_.valid() || task_.wait_for(time) != std::future_status::timeout;
  }

  // Waits for the task, if there is one. Throws what it has thrown.
  void finish() {
    if (task_.valid()) task_.get();
  }

 private:
  std::future<void> task_;
};

}  // namespace fb
