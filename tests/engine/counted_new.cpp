#include "counted_new.h"

#include <atomic>
#include <cstdlib>
#include <new>

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#include <sanitizer/allocator_interface.h>
#define FB_SANITIZER_HOOKS
#endif
#endif

namespace {
std::atomic<long> allocations{0};
}

long allocation_count() {
  return allocations;
}

#if defined(FB_SANITIZER_HOOKS)
// ThreadSanitizer's own operators cannot be replaced; it calls this for each block of memory.
[[maybe_unused]] static const int hooks = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t) { ++allocations; }, [](const volatile void*) {});
#else
// In a file of their own: where GCC sees both through inlining, it takes the pair for a mismatch.
void* operator new(std::size_t bytes) {
  ++allocations;
  if (void* made = std::malloc(bytes > 0 ? bytes : 1)) return made;
  throw std::bad_alloc();
}
void operator delete(void* made) noexcept {
  std::free(made);
}
void operator delete(void* made, std::size_t) noexcept {
  std::free(made);
}
#endif
