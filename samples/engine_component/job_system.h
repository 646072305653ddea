// A job system as engines have one: threads that live as long as the engine and share the work of a loop.
#pragma once

#include <facebaker/facebaker.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

namespace engine {

class JobSystem {
 public:
  // `workers` >= 1, of which the thread that asks for a loop is one.
  explicit JobSystem(std::uint32_t workers);
  ~JobSystem();
  JobSystem(const JobSystem&) = delete;
  JobSystem& operator=(const JobSystem&) = delete;

  std::uint32_t workers() const { return static_cast<std::uint32_t>(threads_.size()) + 1; }
  std::uint64_t loops() const { return loops_; }

  // fb_parallel_for; `user` is the JobSystem. One loop at a time.
  static void parallel_for(void* user, std::uint32_t count, std::uint32_t workers, fb_task task, void* context);

 private:
  void work(std::uint32_t worker);
  void run(std::uint32_t worker);

  std::vector<std::thread> threads_;
  std::mutex mutex_;
  std::condition_variable begun_, done_;
  // The loop of this moment.
  fb_task task_ = nullptr;
  void* context_ = nullptr;
  std::uint32_t count_ = 0, worker_limit_ = 0, running_ = 0;
  std::atomic<std::uint32_t> next_{0};
  std::uint64_t loops_ = 0;
  bool ends_ = false;
};

}  // namespace engine
