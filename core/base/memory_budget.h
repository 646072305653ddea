#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <memory_resource>
#include <string>
#include <vector>

#include "base/small_blocks.h"

namespace fb {

// Memory with a limit: for loading untrusted bytes. As a memory resource it charges what it allocates, small blocks by
// chunks, for as long as it is allocated; what comes from elsewhere is charged by take(). Everything fails with `limit`
// before it exceeds the limit. Not thread-safe.
class MemoryBudget final : public std::pmr::memory_resource {
 public:
  // `host`: where it takes from instead of the heap. It and this object must outlive what is made here, but for the
  // vectors that resize() and reserve() fill, which do not need this object without a host.
  explicit MemoryBudget(std::uint64_t limit = UINT64_MAX, std::pmr::memory_resource* host = nullptr)
      : hosted_(host),
        memory_(host ? *host : *std::pmr::new_delete_resource()),
        charging_(*this),
        blocks_(charging_),
        limit_(limit) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  std::uint64_t used() const { return used_; }
  std::uint64_t peak() const { return peak_; }  // the most there ever was in use

  // Charges a block of `count` items of `size` bytes that is about to be allocated, and returns how much. `what` it is
  // for goes into the message.
  std::uint64_t take(std::uint64_t count, std::size_t size, const char* what);
  void give_back(std::uint64_t charged) noexcept { used_ -= charged; }
  // The same for the text of a std::string, as far as it takes a block.
  void take_text(std::size_t length, const char* what);

  // Charges the items for good, then makes room for them in an empty vector that outlives this object.
  template <class T>
  void reserve(std::vector<T>& items, std::uint64_t count, const char* what) {
    take(count, sizeof(T), what);
    items.reserve(static_cast<std::size_t>(count));
  }
  template <class T>
  void resize(std::vector<T>& items, std::uint64_t count, const char* what) {
    take(count, sizeof(T), what);
    items.resize(static_cast<std::size_t>(count));
  }

  // The same of a vector that takes a host's memory, if there is one, and is then charged as long as it lives.
  template <class T>
  void reserve(std::pmr::vector<T>& items, std::uint64_t count, const char* what) {
    const std::uint64_t charged = take(count, sizeof(T), what);
    if (hosted_) {
      give_back(charged);
      // No assignment changes where a vector takes its memory.
      std::destroy_at(&items);
      std::construct_at(&items, &blocks_);
    }
    items.reserve(static_cast<std::size_t>(count));
  }
  template <class T>
  void resize(std::pmr::vector<T>& items, std::uint64_t count, const char* what) {
    reserve(items, count, what);
    items.resize(static_cast<std::size_t>(count));
  }

  // Charged memory of another resource.
  void* allocate_from(std::pmr::memory_resource& upstream, std::size_t bytes, std::size_t alignment);
  void return_to(std::pmr::memory_resource& upstream, void* memory, std::size_t bytes, std::size_t alignment);

 private:
  // What chunks and large blocks come from.
  class Charging final : public std::pmr::memory_resource {
   public:
    explicit Charging(MemoryBudget& budget) : budget_(budget) {}

   private:
    void* do_allocate(std::size_t bytes, std::size_t alignment) override {
      return budget_.allocate_from(budget_.memory_, bytes, alignment);
    }
    void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override {
      budget_.return_to(budget_.memory_, memory, bytes, alignment);
    }
    bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

    MemoryBudget& budget_;
  };

  void* do_allocate(std::size_t bytes, std::size_t alignment) override { return blocks_.allocate(bytes, alignment); }
  void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override {
    blocks_.deallocate(memory, bytes, alignment);
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  const bool hosted_;
  std::pmr::memory_resource& memory_;
  Charging charging_;
  SmallBlocks blocks_;
  std::uint64_t limit_, used_ = 0, peak_ = 0;
};

// A charge that ends with its scope.
class ScopedCharge {
 public:
  ScopedCharge(MemoryBudget& budget, std::uint64_t count, std::size_t size, const char* what)
      : budget_(budget), charged_(budget.take(count, size, what)) {}
  ~ScopedCharge() { budget_.give_back(charged_); }
  ScopedCharge(const ScopedCharge&) = delete;
  ScopedCharge& operator=(const ScopedCharge&) = delete;

 private:
  MemoryBudget& budget_;
  std::uint64_t charged_;
};

// Memory of another resource, charged to a budget. Both must outlive it.
class ChargedMemory final : public std::pmr::memory_resource {
 public:
  ChargedMemory(std::pmr::memory_resource& upstream, MemoryBudget& budget) : upstream_(upstream), budget_(budget) {}

 private:
  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    return budget_.allocate_from(upstream_, bytes, alignment);
  }
  void do_deallocate(void* memory, std::size_t bytes, std::size_t alignment) override {
    budget_.return_to(upstream_, memory, bytes, alignment);
  }
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  std::pmr::memory_resource& upstream_;
  MemoryBudget& budget_;
};

}  // namespace fb
