#pragma once

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace fb::runtime {

// While it lives, this thread rounds to nearest and keeps denormals, whatever mode the host set; then the host's mode
// is back. Without it the same pose would give other bits in a game that flushes denormals. Arithmetic that relies on
// it belongs in a function the compiler does not inline into the scope that holds it.
class FloatState {
 public:
#if defined(__SSE2__)
  FloatState() : saved_(_mm_getcsr()) {
    _mm_setcsr(0x1f80);
  }
  ~FloatState() {
    _mm_setcsr(saved_);
  }

 private:
  unsigned saved_;
#elif defined(__aarch64__)
  FloatState() {
    asm volatile("mrs %0, fpcr" : "=r"(saved_));
    asm volatile("msr fpcr, %0" : : "r"(0ul));
  }
  ~FloatState() {
    asm volatile("msr fpcr, %0" : : "r"(saved_));
  }

 private:
  unsigned long saved_;
#else
  FloatState() {}
  ~FloatState() {}
#endif

 public:
  FloatState(const FloatState&) = delete;
  FloatState& operator=(const FloatState&) = delete;
};

}  // namespace fb::runtime
