// A race on purpose: two workers of a parallel loop write one number. ThreadSanitizer that is silent here would be
// silent in all tests.
#include <atomic>
#include <cstdio>

#include "base/parallel.h"

int main() {
  std::atomic<int> present{0};
  int number = 0;
  fb::parallel_for({.threads = 2}, 2, [&](std::size_t index, std::size_t) {
    present.fetch_add(1, std::memory_order_relaxed);  // relaxed: orders nothing
    for (int tries = 0; tries < 1'000'000'000 && present.load(std::memory_order_relaxed) < 2; ++tries) {
    }
    number = static_cast<int>(index);
  });
  std::printf("written by %d\n", number);
}
