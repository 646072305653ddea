#pragma once

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <unistd.h>

#include <cstddef>
#include <vector>

namespace fb {

// Threads that call body(index) once each, index counting from 0, beside the caller's; joined at the end of the team's
// life. In the threads nothing is taken from the heap, which would set aside address space for each. The body throws
// nothing and lives as long.
template <class Body>
class ThreadTeam {
 public:
  // Starts `wanted` threads, or as many as the system lets run.
  ThreadTeam(std::size_t wanted, const Body& body) : members_(wanted) {
    for (; count_ < wanted; ++count_) {
      members_[count_].body = &body;
      members_[count_].index = count_;
      if (!members_[count_].start()) break;
    }
  }
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;
  ~ThreadTeam() {
    for (std::size_t i = 0; i < count_; ++i) members_[i].join();
  }
  std::size_t count() const { return count_; }

 private:
  struct Member {
    const Body* body = nullptr;
    std::size_t index = 0;
    pthread_t handle{};
    pid_t id = 0;

    bool start() {
      const auto run = [](void* member) -> void* {
        auto* const self = static_cast<Member*>(member);
#ifdef __linux__
        self->id = gettid();
#endif
        (*self->body)(self->index);
        return nullptr;
      };
      return pthread_create(&handle, nullptr, run, this) == 0;
    }
    void join() const {
      pthread_join(handle, nullptr);
#ifdef __linux__  // counts for limits until it is gone, a little later
      for (int tries = 0; tries < 10000 && tgkill(getpid(), id, 0) == 0; ++tries) sched_yield();
#endif
    }
  };

  std::vector<Member> members_;
  std::size_t count_ = 0;
};

}  // namespace fb
