#include "job_system.h"

namespace engine {

JobSystem::JobSystem(std::uint32_t workers) {
  for (std::uint32_t worker = 1; worker < workers; ++worker) threads_.emplace_back([this, worker] { work(worker); });
}

JobSystem::~JobSystem() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ends_ = true;
  }
  begun_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void JobSystem::parallel_for(void* user, std::uint32_t count, std::uint32_t workers, fb_task task, void* context) {
  auto& self = *static_cast<JobSystem*>(user);
  {
    const std::lock_guard<std::mutex> lock(self.mutex_);
    self.task_ = task;
    self.context_ = context;
    self.count_ = count;
    self.worker_limit_ = workers;
    self.next_ = 0;
    self.running_ = static_cast<std::uint32_t>(self.threads_.size());
    ++self.loops_;
  }
  self.begun_.notify_all();
  self.run(0);
  std::unique_lock<std::mutex> lock(self.mutex_);
  self.done_.wait(lock, [&] { return self.running_ == 0; });
}

void JobSystem::run(std::uint32_t worker) {
  if (worker >= worker_limit_) return;
  for (std::uint32_t index = next_++; index < count_; index = next_++) task_(context_, index, worker);
}

void JobSystem::work(std::uint32_t worker) {
  std::uint64_t seen = 0;
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    begun_.wait(lock, [&] { return ends_ || loops_ != seen; });
    if (ends_) return;
    seen = loops_;
    lock.unlock();
    run(worker);
    lock.lock();
    if (--running_ == 0) done_.notify_one();
  }
}

}  // namespace engine
