// An engine's allocator as the library calls it: counts what one kind of asset takes, and refuses beyond a budget.
#pragma once

#include <facebaker/facebaker.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <new>

namespace engine {

// Thread-safe. Must outlive the models that were loaded with it.
class HostAllocator {
 public:
  explicit HostAllocator(std::size_t budget) : budget_(budget) {}

  fb_allocator callbacks() {
    fb_allocator result = {};
    result.user = this;
    result.allocate = allocate;
    result.release = release;
    return result;
  }
  std::size_t bytes() const { return bytes_; }
  std::uint64_t allocations() const { return allocations_; }

 private:
  static void* allocate(void* user, std::size_t bytes, std::size_t alignment) {
    auto& self = *static_cast<HostAllocator*>(user);
    ++self.allocations_;
    void* memory = nullptr;
    if ((self.bytes_ += bytes) <= self.budget_)
      memory = ::operator new(bytes, std::align_val_t(alignment), std::nothrow);
    if (!memory) self.bytes_ -= bytes;  // the library reports FB_ERROR_OUT_OF_MEMORY
    return memory;
  }
  static void release(void* user, void* memory, std::size_t bytes, std::size_t alignment) {
    ::operator delete(memory, std::align_val_t(alignment));
    static_cast<HostAllocator*>(user)->bytes_ -= bytes;
  }

  std::size_t budget_;
  std::atomic<std::size_t> bytes_{0};
  std::atomic<std::uint64_t> allocations_{0};
};

}  // namespace engine
