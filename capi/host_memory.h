#pragma once

#include <facebaker/facebaker.h>

#include <memory_resource>
#include <new>

namespace fb::capi {

// Memory from a host's fb_allocator, or from malloc if it has none.
class HostMemory final : public std::pmr::memory_resource {
 public:
  explicit HostMemory(const fb_allocator& allocator) : allocator_(allocator) {}

 private:
  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    if (!allocator_.allocate) return std::pmr::new_delete_resource()->allocate(bytes, alignment);
    void* memory = allocator_.allocate(allocator_.user, bytes, alignment);
    if (!memory) throw std::bad_alloc();
    return memory;
  }
  void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override {
    if (!allocator_.allocate) return std::pmr::new_delete_resource()->deallocate(memory, bytes, alignment);
    allocator_.release(allocator_.user, memory, bytes, alignment);
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  fb_allocator allocator_;
};

}  // namespace fb::capi
