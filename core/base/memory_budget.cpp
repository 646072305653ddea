#include "base/memory_budget.h"

#include <algorithm>

#include "base/status.h"

namespace fb {
namespace {

// What a block takes from the heap: with its header, rounded; large blocks are whole pages of their own.
constexpr std::uint64_t heap_bytes(std::uint64_t bytes) {
  if (bytes == 0) return 0;
  if (bytes >= std::uint64_t(128) << 10) return (bytes + 16 + 4095) / 4096 * 4096;
  return std::max<std::uint64_t>(32, (bytes + 8 + 15) / 16 * 16);
}

std::uint64_t block_bytes(std::size_t bytes, std::size_t alignment) {
  return heap_bytes(alignment > alignof(std::max_align_t) ? bytes + alignment : bytes);
}

}  // namespace

std::uint64_t MemoryBudget::take(std::uint64_t count, std::size_t size, const char* what) {
  const std::uint64_t left = limit_ - used_;
  const std::uint64_t bytes = count <= left / size ? heap_bytes(count * size) : UINT64_MAX;
  if (bytes > left)
    fail(Status::limit, "%s: %llu bytes, beside %llu in use, go beyond the limit of %llu bytes", what,
         (unsigned long long)(count <= UINT64_MAX / size ? count * size : UINT64_MAX), (unsigned long long)used_,
         (unsigned long long)limit_);
  used_ += bytes;
  peak_ = std::max(peak_, used_);
  return bytes;
}

void MemoryBudget::take_text(std::size_t length, const char* what) {
  if (length > std::string().capacity()) take(length + 1, 1, what);
}

void* MemoryBudget::allocate_from(std::pmr::memory_resource& upstream, std::size_t bytes, std::size_t alignment) {
  const std::uint64_t charged = take(block_bytes(bytes, alignment), 1, "the model");
  try {
    return upstream.allocate(bytes, alignment);
  } catch (...) {
    give_back(charged);
    throw;
  }
}

void MemoryBudget::return_to(std::pmr::memory_resource& upstream, void* memory, std::size_t bytes,
                             std::size_t alignment) {
  upstream.deallocate(memory, bytes, alignment);
  give_back(heap_bytes(block_bytes(bytes, alignment)));
}

}  // namespace fb
