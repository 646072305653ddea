#include "base/large_pages.h"

#include <memory>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "base/checked.h"

namespace fb {

LargePages::~LargePages() {
  for (const Block& block : blocks_) upstream_.deallocate(block.first, block.size, page);
}

void* LargePages::do_allocate(std::size_t bytes, std::size_t alignment) {
  if (!std::align(alignment, bytes, free_, left_)) {
    const std::size_t size = checked_add(bytes, page - 1, "a block of memory") / page * page;
    blocks_.reserve(blocks_.size() + 1);
    auto* const first = static_cast<std::byte*>(upstream_.allocate(size, page));
    blocks_.push_back({first, size});
#if defined(__linux__)
    madvise(first, size, MADV_HUGEPAGE);  // if refused, pages have the normal size
#endif
    free_ = first;
    left_ = size;
  }
  void* const memory = free_;
  free_ = static_cast<std::byte*>(free_) + bytes;
  left_ -= bytes;
  return memory;
}

}  // namespace fb
