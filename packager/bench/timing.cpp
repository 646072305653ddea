#include "bench/timing.h"

#include <algorithm>

#include "base/thread_time.h"

namespace fb::tool {
namespace {

// The value that a share of the numbers is below; `sorted` ascending, not empty.
double quantile(const std::vector<double>& sorted, double share) {
  return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * double(sorted.size())))];
}

std::vector<double> sorted(std::vector<double> numbers) {
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace

void Timing::measure(std::size_t pose) {
  static const double thread_overhead = clock_overhead(thread_time), elapsed_overhead = clock_overhead(elapsed_time);
  const auto clock = elapsed ? elapsed_time : thread_time;
  const double used_before = elapsed ? process_time() : 0;
  const double start = clock();
  run(pose);
  const double taken = clock() - start - (elapsed ? elapsed_overhead : thread_overhead);
  times.push_back(std::max(0.0, taken) / double(poses_a_call));
  if (elapsed) {
    used += process_time() - used_before;
    passed += taken;
  }
}

SpeedLine Timing::line(std::size_t rounds) const {
  const std::vector<double> ordered = sorted(times);
  const std::size_t p99 = (ordered.size() * 99 + 99) / 100 - 1;
  return {name,
          ordered.front(),
          quantile(ordered, 0.5),
          ordered[p99],
          bytes,
          spread_between_rounds(times, rounds),
          elapsed,
          passed > 0 ? used / passed : 0};
}

double spread_between_rounds(const std::vector<double>& times, std::size_t rounds) {
  const std::size_t length = rounds > 0 ? times.size() / rounds : 0;
  if (rounds < 2 || length == 0) return 0;
  std::vector<double> medians;
  for (std::size_t round = 0; round < rounds; ++round) {
    const auto begin = times.begin() + std::ptrdiff_t(round * length);
    medians.push_back(quantile(sorted({begin, begin + std::ptrdiff_t(length)}), 0.5));
  }
  medians = sorted(medians);
  const double median = quantile(sorted(times), 0.5);
  // Of few rounds the quartiles are the ends.
  const std::size_t quarter = medians.size() / 4;
  return median > 0 ? (medians[medians.size() - 1 - quarter] - medians[quarter]) / median : 0;
}

}  // namespace fb::tool
