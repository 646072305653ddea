// Clocks for measuring.
#pragma once

#include <algorithm>
#include <chrono>
#include <ctime>

namespace fb {

// Time that passes, in microseconds.
inline double elapsed_time() {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Processor time of all threads of this process in microseconds; 0 where the system has no such clock.
inline double process_time() {
#if defined(CLOCK_PROCESS_CPUTIME_ID)
  timespec time;
  if (clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time) == 0)
    return double(time.tv_sec) * 1e6 + double(time.tv_nsec) * 1e-3;
#endif
  return 0;
}

// Processor time of this thread in microseconds, where the system has such a clock, so that other programs on a shared
// machine do not count; else wall time.
inline double thread_time() {
#if defined(CLOCK_THREAD_CPUTIME_ID)
  timespec time;
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time) == 0)
    return double(time.tv_sec) * 1e6 + double(time.tv_nsec) * 1e-3;
#endif
  return elapsed_time();
}

// Time that one call of a clock takes at least, which is subtracted from what is measured: of a busy machine any other
// figure, such as the median, may be more than a short call takes.
inline double clock_overhead(double (*clock)()) {
  double least = 1e30;
  for (int n = 0; n < 2000; ++n) {
    const double start = clock();
    least = std::min(least, clock() - start);
  }
  return least;
}

}  // namespace fb
