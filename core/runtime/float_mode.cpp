#include "runtime/float_mode.h"

#include <cstdint>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace fb::runtime {
namespace {

// Sets the mode of this thread and restores it.
class FloatMode {
 public:
#if defined(__SSE2__)
  FloatMode() : saved_(_mm_getcsr()) {
    _mm_setcsr(0x1f80);
  }
  ~FloatMode() {
    _mm_setcsr(saved_);
  }

 private:
  unsigned saved_;
#elif defined(__aarch64__)
  FloatMode() {
    asm volatile("mrs %0, fpcr" : "=r"(saved_));
    asm volatile("msr fpcr, %0" : : "r"(std::uint64_t(0)));
  }
  ~FloatMode() {
    asm volatile("msr fpcr, %0" : : "r"(saved_));
  }

 private:
  std::uint64_t saved_;
#else
  FloatMode() {}
  ~FloatMode() {}
#endif

 public:
  FloatMode(const FloatMode&) = delete;
  FloatMode& operator=(const FloatMode&) = delete;
};

}  // namespace

[[gnu::noinline]] void call_with_float_mode(void (*call)(void* work), void* work) {
  const FloatMode mode;
  call(work);
}

}  // namespace fb::runtime
