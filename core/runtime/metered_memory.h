#pragma once

#include <cstddef>
#include <cstdint>
#include <memory_resource>

namespace fb::runtime {

// Counts the bytes allocated from another resource, so that a model's footprint is known. Not thread-safe.
class MeteredMemory final : public std::pmr::memory_resource {
 public:
  explicit MeteredMemory(std::pmr::memory_resource& upstream) : upstream_(upstream) {}
  std::uint64_t bytes() const { return bytes_; }

 private:
  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
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
  std::uint64_t bytes_ = 0;
};

}  // namespace fb::runtime
