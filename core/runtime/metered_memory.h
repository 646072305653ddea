#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>

#include "base/status.h"

namespace fb::runtime {

// Counts the bytes allocated from another resource and limits them, so that a model's footprint is known and a hostile
// archive cannot exceed the loader's limit. Fails with Status::limit. Not thread-safe.
class MeteredMemory final : public std::pmr::memory_resource {
 public:
  MeteredMemory(std::pmr::memory_resource& upstream, std::uint64_t limit) : upstream_(upstream), limit_(limit) {}
  std::uint64_t bytes() const { return bytes_; }

 private:
  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    if (bytes > limit_ - bytes_)
      fail(Status::limit, "the model takes more than the limit of %llu bytes", (unsigned long long)limit_);
    void* memory = upstream_.allocate(bytes, alignment);
    bytes_ += bytes;
    return memory;
  }
  void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override {
    upstream_.deallocate(memory, bytes, alignment);
    bytes_ -= bytes;
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  std::pmr::memory_resource& upstream_;
  std::uint64_t limit_, bytes_ = 0;
};

}  // namespace fb::runtime
