#pragma once

#include <cstddef>
#include <memory_resource>
#include <vector>

namespace fb {

// An arena for long-lived, randomly accessed memory, in blocks of 2 MB pages where the system has them: fewer TLB
// misses when a model is cold. Blocks come from `upstream`, which must outlive the arena, and are released when the
// arena is destroyed; deallocating does nothing. Not thread-safe.
class LargePages final : public std::pmr::memory_resource {
 public:
  static constexpr std::size_t page = std::size_t(2) << 20;

  explicit LargePages(std::pmr::memory_resource& upstream = *std::pmr::new_delete_resource()) : upstream_(upstream) {}
  LargePages(const LargePages&) = delete;
  LargePages& operator=(const LargePages&) = delete;
  ~LargePages() override;

 private:
  void* do_allocate(std::size_t bytes, std::size_t alignment) override;
  void do_deallocate(void*, std::size_t, std::size_t) override {}
  bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }

  struct Block {
    std::byte* first;
    std::size_t size;
  };
  std::pmr::memory_resource& upstream_;
  std::vector<Block> blocks_;
  void* free_ = nullptr;  // in the last block
  std::size_t left_ = 0;
};

}  // namespace fb
