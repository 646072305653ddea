#pragma once

#include <chrono>
#include <ctime>

namespace fb::tool {

// Microseconds this thread has run, where the system tells: what other programs take of a shared machine is not
// counted.
inline double thread_time() {
#if defined(CLOCK_THREAD_CPUTIME_ID)
  timespec time;
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time) == 0)
    return double(time.tv_sec) * 1e6 + double(time.tv_nsec) * 1e-3;
#endif
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace fb::tool
